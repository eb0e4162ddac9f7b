# The types of stigmergy.py when it is compiled.
cimport cython
from colonysim.policies.choice cimport sample, softmax
from colonysim.policies.view cimport FieldWindow, LocalView


cdef class Stigmergy:
    cdef public object settings
    cdef public str name
    cdef int _goal

    @cython.locals(box=int, hole=int, node=int)
    cdef _carry(self, LocalView view, memory)
    cdef bint _impatient(self, LocalView view)
    @cython.locals(at=int, best=int, j=int, best_scent=double, scent=double, trail=FieldWindow)
    cdef tuple _way(self, LocalView view, int box, int hole, tuple planned=*)
    cdef tuple _likely_way(self, LocalView view, int box, int hole, tuple way, tuple planned=*)
    cpdef bint _has_room(self, LocalView view, int box, int hole)
    cdef _choose(self, LocalView view, memory, random)
    @cython.locals(box=int, first=int, worth=FieldWindow)
    cdef _exploit(self, LocalView view, memory, random, list options)
    @cython.locals(i=int, values=list)
    cdef _follow_distance(self, LocalView view, memory, random, list options, int box, int towards, target)
    cpdef bint _allowed(self, LocalView view, int node)
    @cython.locals(at=int, centre=int, hole=int, j=int, asked=cython.bint, trail=FieldWindow)
    cpdef list _targets(self, LocalView view, memory, int box, int from_node)
    @cython.locals(box=int, at=int, marks=FieldWindow)
    cdef _explore(self, LocalView view, memory, random, list options)
    cdef dict _boxes_to_pass(self, LocalView view, memory)
    @cython.locals(at=int, first=int)
    cdef tuple _claim(self, LocalView view, memory, int box, int hole, tuple way)
