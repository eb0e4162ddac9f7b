# The types of hole.py when it is compiled.
cimport cython
from colonysim.exact cimport exp
from colonysim.world.state cimport World

cdef double FARTHEST, NOWHERE


cdef class HoleTrail:
    cdef object _best, _new, _place, _found
    cdef World _world
    cdef double _keep, _aged
    cdef bint _printed, _everywhere
    cdef dict _far

    @cython.locals(far=double)
    cpdef double at(self, int node, int key=*)
    @cython.locals(trails=tuple, holes="int[::1]", fars="double[::1]", k=int)
    cpdef double farness(self, int node, int hole)
    @cython.locals(
        world=World, aged=double, trails=tuple, holes="int[::1]", fars="double[::1]", best="double[::1]", place="int[::1]",
        found="int[::1]", count=int, hole=int, length=double, far=double, through=double, k=int, i=int, writes=list, fresh=list,
    )
    cdef list _update(self, int node, double level)
