# The types of exploration.py when it is compiled.
cimport cython
from colonysim.pheromones.field cimport Visit
from colonysim.pheromones.marks cimport Fading, Marks, each_node
from colonysim.pheromones.spreading cimport NodeValues
from colonysim.world.state cimport World


cdef class Exploration(Marks):
    cdef public World _world
    cdef Fading _fading
    cdef readonly NodeValues spread
    cdef object _keep
    cdef bint _on_wait, _at_start
    cdef readonly double[::1] stored
    cdef readonly unsigned char[::1] visited
    cdef readonly double scale, shift

    @cython.locals(twin=Exploration)
    cpdef __deepcopy__(self, memo)
    @cython.locals(node=int)
    cpdef frame(self)
    @cython.locals(value=double)
    cpdef double at(self, int node, int key=*) except? -1
    cpdef double value(self, int i) except? -1
    @cython.locals(node=int)
    cpdef wipe(self, nodes)
    cpdef settle(self)
    @cython.locals(node=int, moment=str, one=double)
    cpdef int mark(self, Visit visit) except -1
    cdef bint _counts(self, str moment) except? -1
