# The types of box.py when it is compiled.
cimport cython
from colonysim.pheromones.field cimport Visit
from colonysim.pheromones.marks cimport Fading, Marks, each_node
from colonysim.world.state cimport World

cdef long long PAIRS


cdef class BoxWorth(Marks):
    cdef public World _world
    cdef public double _start, _decay, _cap
    cdef public bint _on_entry, _whole_stack
    cdef dict _worth
    cdef Fading _fading
    cdef long long _holes
    cdef int[::1] _hole_at

    @cython.locals(twin=BoxWorth)
    cpdef __deepcopy__(self, memo)
    cpdef double at(self, int node, int key=*) except? -1
    @cython.locals(hole=int)
    cpdef int mark(self, Visit visit) except -1
    @cython.locals(known=double)
    cdef _set(self, int box, int hole, double value)
    @cython.locals(crossed=int)
    cdef int _crossed(self, int node, int left, int before) except? -2
    @cython.locals(pushed=int, box=int, value=double, crossed_on=list)
    cdef _credit(self, int hole, int agent)
