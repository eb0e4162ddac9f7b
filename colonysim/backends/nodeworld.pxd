# The types of nodeworld.py when it is compiled.
cimport cython
from colonysim.backends.motion cimport Motion
from colonysim.draws cimport Draws
from colonysim.world.state cimport World
from colonysim.world.terrain cimport Terrain

@cython.locals(at=int, base=double, j=int, found=list)
cpdef list what_can_be_pushed(World world, int box, targets)


cdef class NodeWorld(Motion):
    cdef public double edge_seconds
    cdef public Draws draws
    cdef World _world
    cdef object _travels, _pushes
    cdef double _fixed, _pace, _push_fixed, _push_pace, _jitter

    @cython.locals(terrain=Terrain, length=double, took=double)
    cdef double _seconds(self, int agent, int i, int j, bint pushed) except? -1
    cpdef needs(self, int agent, int node, int box, int hole)
    @cython.locals(world=World, at=int)
    cpdef double undertake(self, int agent, int node, int box, int hole, double now) except? -2
