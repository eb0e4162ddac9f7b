# The types of hole.py when it is compiled.
cimport cython
from colonysim.exact cimport exp

cdef double FARTHEST, NOWHERE


cdef class HoleTrail:
    cdef object _world
    cdef double _keep, _aged
    cdef bint _printed, _everywhere
    cdef dict _far

    @cython.locals(far=double)
    cpdef double at(self, int node, int key=*)
    @cython.locals(trails=dict)
    cpdef double farness(self, int node, int hole)
    @cython.locals(world=object, aged=double, trails=dict, theirs=dict, found=dict, writes=list, length=double, far=double, through=double)
    cdef list _update(self, int node, double level)
