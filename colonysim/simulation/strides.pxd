# The types of strides.py when it is compiled.
cimport cython
from colonysim.exact cimport exp
from colonysim.trace.rows cimport Rows
from colonysim.world.sight cimport Sight

cdef double UNKNOWN


cdef class Strides:
    cdef int goal, max_steps
    cdef double reach, d_max, scale, shift, beta, fixed, pace, jitter
    cdef bint lrta, blank, marks_waits
    cdef int[::1] first, ends, occupant, node_holder, agent_node, agent_from, agent_box, target, ways, options
    cdef double[::1] box_base, lengths, rises, surface, d, straight, stored, epsilon, began, chances
    cdef unsigned char[::1] official, known, visited, moved
    cdef list reserved, jitters, memories, views, draw, steps
    cdef dict clear_requests
    cdef object worth, trail, measured, visit
    cdef Rows rows
    cdef Sight sight

    @cython.locals(
        node=int, steps=int, level=double, reach=double, way=int, j=int, target=int, count=int, chosen=int, surface="double[::1]",
        occupant="int[::1]", holder="int[::1]", ends="int[::1]", options="int[::1]", explored=cython.bint,
    )
    cpdef double depart(self, int agent, double now)

    cdef double hand_back(self, int agent)

    @cython.locals(i=int, last=int, chosen=int, top=double, total=double, chances="double[::1]", options="int[::1]", beta=double)
    cdef int choose(self, int count, bint explored, double rest)

    cdef double crowding(self, int node)

    @cython.locals(value=double)
    cdef double nearness(self, int node)

    @cython.locals(took=double)
    cdef double seconds(self, int agent, int i, int j, double length)

    @cython.locals(origin=int, node=int, before=int)
    cpdef tuple arrive(self, int agent)

    @cython.locals(node=int, held=int, level=double, stays=cython.bint, rows=Rows)
    cpdef mark(self, str moment, int agent, int box, int hole, int left, int before)

    @cython.locals(
        d="double[::1]", official="unsigned char[::1]", surface="double[::1]", reach=double, best=double, best_official=double,
        way=int, j=int, through=double, value=double,
    )
    cdef update_distance(self, int node, double level)
