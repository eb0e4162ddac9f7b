# The types of state.py when it is compiled.
cimport cython
from colonysim.world.visibility cimport Visibility
from colonysim.world.terrain cimport Terrain


@cython.final
cdef class World:
    cdef readonly object scenario, topology
    cdef readonly double[::1] floor, surface, rim, box_base, box_height
    cdef readonly int[::1] hole_node, hole_at, occupant, node_holder, top, box_node, agent_node, agent_from, agent_box
    cdef readonly list box_claim, box_stray, agent_status, reserved
    cdef readonly dict stacks, clear_requests, edge_holder
    cdef readonly Terrain terrain
    cdef public double now
    cdef readonly int goal
    cdef Visibility _visibility
    cdef list _sights
    cdef int _requests
    cdef int[::1] _requests_near

    @cython.locals(node=int)
    cpdef reset(self)
    @cython.locals(box=int)
    cpdef double level(self, int agent)
    cpdef bint arrived(self, int agent)
    @cython.locals(edge=int)
    cpdef bint passable(self, double level, int i, int j) except? -1
    @cython.locals(terrain=Terrain, edge=int, found=list)
    cpdef list reachable_neighbours(self, double level, int node)
    @cython.locals(node=int, level=double, terrain=Terrain, count=int, edge=int, j=int)
    cpdef int exits(self, int agent, int[::1] found) except -1
    cpdef bint adjacent(self, int i, int j) except? -1
    @cython.locals(terrain=Terrain, edge=int, j=int)
    cpdef bint beside_box(self, int node, int other) except? -1
    @cython.locals(terrain=Terrain, edge=int, j=int)
    cpdef bint box_at_hand(self, int node) except? -1
    cpdef double headroom(self, int hole) except? -1
    cpdef bint filled(self, int hole) except? -1
    cpdef double base_of(self, int box, int node) except? -1
    @cython.locals(box=int)
    cpdef int held_box(self, int agent) except? -2
    @cython.locals(at=int, claim=int, edge=int, rise=double)
    cpdef bint graspable(self, int agent, int box, double level, int node) except? -1
    @cython.locals(edge=int)
    cpdef bint can_slide(self, double base, int i, int j) except? -1
    @cython.locals(edge=int)
    cpdef bint falls(self, double base, int i, int j) except? -1
    @cython.locals(at=int, terrain=Terrain, edge=int, base=double)
    cpdef int prospect(self, int agent, int node, int box) except? -9
    @cython.locals(occupant=int, holder=int)
    cpdef bint free(self, int agent, int node)
    @cython.locals(occupant=int)
    cpdef bint occupied_by_another(self, int agent, int node) except? -1
    cpdef Visibility visibility(self)
    @cython.locals(found=Visibility)
    cpdef Visibility visibility_of(self, int agent)
    cpdef list boxes_near(self, int node)
    cpdef tuple holes_near(self, int node)
    @cython.locals(terrain=Terrain, edge=int)
    cdef _count_request(self, int node, int more)
    cpdef bint requested_near(self, int node)
    cpdef bint reserve_node(self, int agent, int node) except? -1
    @cython.locals(held=tuple)
    cdef tuple _free_held(self, int agent)
    @cython.locals(claimed=cython.bint, held=int)
    cpdef bint claim(self, int agent, int pushed)
    @cython.locals(origin=int)
    cpdef arrive(self, int agent, int node, int box, int to)
    @cython.locals(origin=int)
    cdef _step(self, int agent, int node)
    cdef _settle_push(self, int agent, int box, int node, int origin)
    @cython.locals(stack=list, base=double, other=int)
    cdef _restack(self, int node)
    @cython.locals(stack=list)
    cdef _put_box(self, int box, int node)
    @cython.locals(old=int)
    cpdef move_box(self, int box, int node)
    @cython.locals(height=double, box=int, stack=list)
    cdef double _height(self, int node)
