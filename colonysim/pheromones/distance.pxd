# The types of distance.py when it is compiled.
cimport cython
from colonysim.pheromones.marks cimport Marks

cdef double UNKNOWN

@cython.locals(
    first="int[::1]", ends="int[::1]", lengths="double[::1]", far="double[::1]", queue=list, d=double, i=int, way=int, j=int,
    through=double, greatest=double,
)
cpdef double _farthest(topology, int goal) except? -1


cdef class Distance(Marks):
    cdef public object _world
    cdef int _goal
    cdef bint _everywhere, _at_start
    cdef public bint lrta, blank
    cdef public double d_max
    cdef public object straight, d, official, visited

    @cython.locals(value=double)
    cpdef double at(self, int node, int key=*) except? -1
    @cython.locals(best=double, best_official=double, through=double, length=double, value=double)
    cpdef _update(self, int node, double level)
