# The types of stigmergy.py when it is compiled.
cimport cython
from colonysim.policies.choice cimport sample, softmax
from colonysim.policies.thought cimport Thought
from colonysim.policies.view cimport FieldWindow, LocalView


cdef class Stigmergy:
    cdef public object settings
    cdef public str name
    cdef int _goal
    cdef double _beta, _patience
    cdef bint _two_node, _ask_to_clear

    @cython.locals(carried=Thought, dropped=int)
    cpdef Thought think(self, LocalView view, memory, random)
    @cython.locals(box=int, hole=int, node=int, way=tuple, thought=Thought)
    cdef Thought _carry(self, LocalView view, memory)
    cdef bint _impatient(self, LocalView view)
    @cython.locals(at=int, best=int, j=int, best_scent=double, scent=double, trail=FieldWindow, way=tuple)
    cdef tuple _way(self, LocalView view, int box, int hole, tuple planned=*, pushes=*)
    cdef tuple _likely_way(self, LocalView view, int box, int hole, tuple way, tuple planned=*)
    cpdef bint _has_room(self, LocalView view, int box, int hole)
    @cython.locals(options=list, epsilon=double, j=int)
    cdef Thought _choose(self, LocalView view, memory, random)
    @cython.locals(box=int, first=int, worth=FieldWindow, values=list, found=list, hole=int, pick=int)
    cdef Thought _exploit(self, LocalView view, memory, random, list options)
    @cython.locals(i=int, values=list, nodes=list, boxes=list, beside=dict, thought=Thought, chances=list)
    cdef Thought _follow_distance(
        self, LocalView view, memory, random, list options, int box=*, int towards=*, double worth=*,
        tuple target=*,
    )
    cdef bint _shut_in(self, LocalView view, list values)
    cpdef bint _allowed(self, LocalView view, int node)
    @cython.locals(
        at=int, centre=int, hole=int, j=int, asked=cython.bint, beside=cython.bint, trail=FieldWindow, way=tuple,
        planned=tuple, found=list, candidates=set, pushes=list,
    )
    cpdef list _targets(self, LocalView view, memory, int box, int from_node)
    @cython.locals(
        box=int, at=int, nodes=list, chances=list, boxes=list, chosen=int, hole=int, thought=Thought, targets=dict, held=dict,
        epsilon=double,
    )
    cdef Thought _explore(self, LocalView view, memory, random, list options)
    cdef dict _boxes_to_pass(self, LocalView view, memory)
    @cython.locals(at=int, thought=Thought)
    cdef Thought _claim(self, LocalView view, memory, int box, int hole, tuple way)
