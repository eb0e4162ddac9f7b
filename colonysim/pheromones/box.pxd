# The types of box.py when it is compiled.
cimport cython
from colonysim.pheromones.marks cimport Marks
from colonysim.world.state cimport World

cdef long long PAIRS


cdef class BoxWorth(Marks):
    cdef public World _world
    cdef public double _start, _decay, _cap
    cdef public bint _on_entry, _whole_stack
    cdef dict _worth
    cdef long long _holes

    cpdef double at(self, int node, int key=*) except? -1
    @cython.locals(value=double)
    cpdef double lower(self, int box, int hole) except? -1
    @cython.locals(crossed=int)
    cpdef int crossed(self, int node, int left, int before) except? -2
    @cython.locals(pushed=int, box=int, value=double, crossed_on=list)
    cpdef list credit(self, int hole, int agent)
