# The types of distance.py when it is compiled.
cimport cython
from colonysim.pheromones.field cimport Visit
from colonysim.pheromones.marks cimport Fading, Marks, each_node
from colonysim.pheromones.spreading cimport NodeValues
from colonysim.world.state cimport World
from colonysim.world.terrain cimport Terrain

cdef double UNKNOWN

@cython.locals(
    first="int[::1]", ends="int[::1]", lengths="double[::1]", far="double[::1]", queue=list, d=double, i=int, edge=int, j=int,
    through=double, greatest=double,
)
cpdef double _farthest(topology, int goal) except? -1


cdef class Distance(Marks):
    cdef public World _world
    cdef int _goal
    cdef bint _everywhere, _at_start, _changes
    cdef readonly bint lrta, blank
    cdef readonly double d_max
    cdef Fading _fading
    cdef readonly NodeValues spread
    cdef readonly double[::1] straight, d
    cdef readonly unsigned char[::1] official, visited

    @cython.locals(twin=Distance)
    cpdef __deepcopy__(self, memo)
    @cython.locals(node=int)
    cpdef frame(self)
    @cython.locals(value=double)
    cpdef double at(self, int node, int key=*) except? -1
    @cython.locals(rest=double)
    cpdef double far(self, int node) except? -1
    @cython.locals(node=int)
    cpdef wipe(self, nodes)
    cpdef settle(self)
    cdef double _rest(self, int node) except? -1
    @cython.locals(rest=double)
    cdef int _store(self, int node, double far) except -1
    @cython.locals(node=int, moment=str)
    cpdef int mark(self, Visit visit) except -1
    @cython.locals(node=int, before=double, surface="double[::1]")
    cdef int _sweep(self, int done) except -1
    @cython.locals(
        terrain=Terrain, changes=cython.bint, best=double, best_official=double, edge=int, j=int,
        through=double, value=double,
    )
    cpdef _update(self, int node, double level)
