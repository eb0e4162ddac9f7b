# The types of state.py when it is compiled.
cimport cython
from colonysim.world.sight cimport Sight
from colonysim.world.terrain cimport Terrain


cdef class World:
    cdef public object scenario, topology, surface, occupant, node_holder, top, hole_at
    cdef public object box_node, box_base, box_height, agent_node, agent_from, agent_box
    cdef public list box_claim, box_stray, agent_status, reserved
    cdef public dict stacks, clear_requests, edge_holder
    cdef readonly Terrain terrain
    cdef int _goal
    cdef double[::1] _heights, _box_bases, _box_heights, _floors, _rims
    cdef int[::1] _first, _ends, _hole_nodes
    cdef int[::1] _occupants, _holders, _tops, _box_nodes, _agent_nodes, _agents_from, _agent_boxes
    cdef Sight _sight
    cdef int _requests
    cdef int[::1] _requests_near

    @cython.locals(box=int)
    cpdef double level(self, int agent)
    cpdef bint arrived(self, int agent)
    @cython.locals(edge=int)
    cpdef bint passable(self, double level, int i, int j) except? -1
    @cython.locals(terrain=Terrain, edge=int, found=list)
    cpdef list ways(self, double level, int node)
    cpdef list exits(self, int agent)
    @cython.locals(node=int, level=double, terrain=Terrain, count=int, edge=int, j=int)
    cpdef int exits_into(self, int agent, int[::1] found)
    cpdef bint adjacent(self, int i, int j) except? -1
    @cython.locals(way=int)
    cpdef bint beside_box(self, int node, int other)
    cpdef int hole_node(self, int hole) except? -1
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
    cpdef Sight sight(self)
    cpdef list boxes_near(self, int node)
    cpdef tuple holes_near(self, int node)
    @cython.locals(way=int)
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
    @cython.locals(stack=list)
    cdef _put_box(self, int box, int node)
    @cython.locals(old=int, stack=list, base=double, other=int)
    cpdef _move_box(self, int box, int node)
    @cython.locals(height=double, box=int, stack=list)
    cdef double _height(self, int node)
