# The types of hole.py when it is compiled.
cimport cython
from colonysim.exact cimport exp
from colonysim.pheromones.field cimport Visit
from colonysim.pheromones.marks cimport Fading, Marks, each_node, gather_keys
from colonysim.pheromones.spreading cimport NodeValues
from colonysim.world.visibility cimport Visibility
from colonysim.world.state cimport World
from colonysim.world.terrain cimport Terrain

cdef double FARTHEST, NOWHERE, LEAST


cdef class HoleTrail(Marks):
    cdef public World _world
    cdef double _keep, _aged
    cdef Fading _fading
    cdef bint _printed, _everywhere, _any, _spreads
    cdef readonly list spread
    cdef object _diffusion, _period
    cdef int _used, _agent
    cdef int[::1] _start, _count, _room, _holes, _place, _found
    cdef double[::1] _fars, _best

    @cython.locals(world=World, twin=HoleTrail)
    cpdef __deepcopy__(self, memo)
    @cython.locals(far=double)
    cpdef double at(self, int node, int key=*) except? -1
    @cython.locals(start=int, k=int, strength=double)
    cpdef double farness(self, int node, int hole)
    @cython.locals(values=NodeValues, strength=double)
    cdef double _strength(self, int node, int hole) except? -1
    @cython.locals(values=NodeValues)
    cdef _write(self, int node, int hole, double strength)
    cdef NodeValues _new_values(self)
    @cython.locals(
        visibility=Visibility, terrain=Terrain, holes=int, hole=int, ways=int, edge=int, j=int, factor=double,
        through=double, near=int, k=int, strength=double, own=double,
    )
    cdef _update_spread(self, int node, double level)
    @cython.locals(node=int)
    cpdef wipe(self, nodes)
    cpdef settle(self)
    cdef double _age(self) except? -1
    @cython.locals(start=int, k=int, hole=int, found=list, aged=double)
    cpdef keys(self, int node)
    @cython.locals(start=int, k=int, hole=int, aged=double)
    cpdef int gather(self, int node, int[::1] found, int count, unsigned char[::1] marked) except -1
    @cython.locals(node=int, surface="double[::1]")
    cpdef int mark(self, Visit visit) except -1
    cpdef double value(self, int i) except? -1
    cdef _update(self, int node, double level)
    @cython.locals(
        visibility=Visibility, aged=double, count=int, near=int, hole=int,
        length=double, far=double, through=double, edge=int, j=int, terrain=Terrain, start=int, k=int, i=int,
    )
    cdef int _update_max(self, int node, double level) except -1
    cdef _update_as_printed(self, int node, double level)
    @cython.locals(start=int, count=int, room=int, k=int)
    cdef _append(self, int node, int hole, double far)
