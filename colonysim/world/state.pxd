# The types of state.py when it is compiled.
cimport cython
from colonysim.world.sight cimport Sight


cdef class World:
    cdef public object scenario, topology, surface, occupant, node_holder, top, hole_at
    cdef public object box_node, box_base, box_height, agent_node, agent_from, agent_box
    cdef public list box_claim, box_stray, agent_status, reserved
    cdef public dict stacks, clear_requests, edge_holder
    cdef double _reach
    cdef int _goal
    cdef object _no_push
    cdef double[::1] _heights, _box_bases, _box_heights, _floors, _rims, _lengths, _slopes
    cdef int[::1] _first, _ends, _hole_nodes
    cdef int[::1] _occupants, _holders, _tops, _box_nodes, _agent_nodes, _agent_boxes
    cdef Sight _sight
    cdef int _requests
    cdef int[::1] _requests_near

    @cython.locals(box=int)
    cpdef double level(self, int agent)
    cpdef bint arrived(self, int agent)
    @cython.locals(reach=double)
    cpdef bint passable(self, double level, int i, int j)
    @cython.locals(way=int)
    cdef double _rise(self, int i, int j)
    @cython.locals(reach=double, way=int, j=int, found=list)
    cpdef list ways(self, double level, int node)
    cpdef list exits(self, int agent)
    @cython.locals(node=int, level=double, reach=double, count=int, way=int, j=int)
    cpdef int exits_into(self, int agent, int[::1] found)
    @cython.locals(way=int, last=int)
    cpdef bint adjacent(self, int i, int j)
    @cython.locals(way=int)
    cpdef bint beside_box(self, int node, int other)
    cpdef int hole_node(self, int hole) except? -1
    @cython.locals(at=int, claim=int, reach=double)
    cpdef bint graspable(self, int agent, int box, double level, int node)
    cpdef bint can_slide(self, double base, int i, int j)
    cpdef bint falls(self, double base, int i, int j)
    @cython.locals(occupant=int, holder=int)
    cpdef bint free(self, int agent, int node)
    cpdef Sight sight(self)
    cpdef list boxes_near(self, int node)
    cpdef tuple holes_near(self, int node)
    @cython.locals(way=int)
    cdef _count_request(self, int node, int more)
    cpdef bint requested_near(self, int node)
    cpdef list _free_held(self, int agent)
    @cython.locals(claimed=cython.bint, held=int)
    cpdef bint claim(self, int agent, int pushed)
    @cython.locals(origin=int)
    cpdef pushed(self, int agent, int box, int to, int node)
    @cython.locals(origin=int)
    cdef _step(self, int agent, int node)
    cdef _settle_push(self, int agent, int box, int node, int origin)
    @cython.locals(stack=list)
    cdef _put_box(self, int box, int node)
    @cython.locals(old=int, stack=list, base=double, other=int)
    cpdef _move_box(self, int box, int node)
    @cython.locals(height=double, box=int, stack=list)
    cdef double _height(self, int node)
