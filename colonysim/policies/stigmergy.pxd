# The types of stigmergy.py when it is compiled.
# Memory is imported by others from here: under its own name it would be a type only.
cimport cython
from colonysim.policies.choice cimport pick, weigh
from colonysim.policies.decision cimport Decider, Decision, Memory as Kept, Options, Stream as Drawn, new_decision, new_memory
from colonysim.policies.view cimport FieldWindow, LocalView


cdef long long NEVER
cdef int HOLE_OPEN


cdef class Stigmergy(Decider):
    cdef public object settings
    cdef public str name
    cdef object _scenario, _place
    cdef long long _tries
    cdef int _room, _most_holes
    cdef long long _restless
    cdef bint _marking
    cdef Options _options
    cdef double _beta, _patience, _least, _reach
    cdef bint _two_node, _ask_to_clear, _overfill, _from_box, _errands, _step_past, _look_on, _per_choice
    cdef bint _weighs
    cdef int[::1] _nodes, _boxes, _pushes, _beside, _holes
    cdef double[::1] _values, _worths
    cdef unsigned char[::1] _marked

    cpdef Decision think(self, LocalView view, memory, Drawn stream)
    @cython.locals(carried=Decision, dropped=int)
    cdef Decision _think(self, LocalView view, Kept memory, draw)
    @cython.locals(box=int, hole=int, node=int, way=tuple, decision=Decision, vain=int)
    cdef Decision _carry(self, LocalView view, Kept memory)
    cdef bint _impatient(self, LocalView view)
    @cython.locals(
        at=int, best=int, best_scent=double, scent=double, trail=FieldWindow, way=tuple, rest=tuple, slides=cython.bint,
        i=int,
    )
    cdef tuple _way(self, LocalView view, int box, int hole, tuple planned=*, int count=*)
    cdef tuple _likely_way(self, LocalView view, int box, int hole, tuple way, tuple planned=*)
    cpdef bint _has_room(self, LocalView view, int box, int hole) except? -1
    @cython.locals(count=int, every=int, i=int, j=int, requested=cython.bint)
    cdef Decision _choose(self, LocalView view, Kept memory, draw)
    @cython.locals(
        box=int, first=int, worth=FieldWindow, found=list, hole=int, chosen=int, i=int, way=tuple, some=cython.bint,
        useless=list, past=cython.bint,
    )
    cdef Decision _exploit(self, LocalView view, Kept memory, draw, int count)
    @cython.locals(
        i=int, options=int, nearness=FieldWindow, decision=Decision,
        node=int, beside=int,
    )
    cdef Decision _follow_distance(
        self, LocalView view, Kept memory, draw, int count, int box=*, int towards=*, double worth=*, int hole=*,
        tuple way=*,
    )
    @cython.locals(i=int, j=int, shut=cython.bint)
    cdef bint _shut_in(self, LocalView view, int options) except? -1
    cpdef bint _allowed(self, LocalView view, int node) except? -1
    @cython.locals(
        at=int, hole=int, asked=cython.bint, own=cython.bint, beside=cython.bint, pushable=int, way=tuple, planned=tuple,
        found=list, i=int,
    )
    cpdef list _targets(self, LocalView view, Kept memory, int box, int from_node)
    cdef list _feasible(self, LocalView view, int box, list found)
    @cython.locals(
        count=int, hole=int, trail=FieldWindow, i=int, place=int,
    )
    cdef int _candidates(self, LocalView view, Kept memory, int box, int at, int pushable) except -1
    @cython.locals(
        box=int, j=int, i=int, chosen=int, hole=int, way=tuple,
        decision=Decision, targets=dict, found=list, holes=list, epsilon=double, crowding=FieldWindow,
    )
    cdef Decision _explore(self, LocalView view, Kept memory, draw, int count)
    @cython.locals(vain="long long", passed=int)
    cdef Decision _look_about(self, LocalView view, Kept memory, draw, int count)
    @cython.locals(
        i=int, j=int,
        box=int, decision=Decision, crowding=FieldWindow,
    )
    cdef Decision _roam(self, LocalView view, Kept memory, draw, int count)
    @cython.locals(i=int, field=FieldWindow, weight=double)
    cdef _weigh_extra(self, LocalView view, int count)
    @cython.locals(place=int, i=int)
    cdef int _insert(self, int count, int node, int box)
    cdef Decision _weighed(self, Decision decision, int count)
    cdef dict _boxes_to_pass(self, LocalView view, Kept memory)
    @cython.locals(at=int, decision=Decision, planned=tuple)
    cdef Decision _claim(self, LocalView view, Kept memory, int box, int hole, tuple way)
