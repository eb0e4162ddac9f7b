# The types of strides.py when it is compiled.
cimport cython
from colonysim.policies.choice cimport sample, softmax
from colonysim.trace.rows cimport Rows

cdef double UNKNOWN


cdef class Strides:
    cdef int goal, max_steps
    cdef double reach, sight, d_max, scale, shift, beta, fixed, pace, jitter
    cdef bint lrta, blank
    cdef tuple ways, x, y
    cdef list surface, occupant, node_holder, reserved, agent_node, agent_from, agent_box, box_node
    cdef list d, official, straight, jitters, memories, views, random, steps, target, began
    cdef dict clear_requests, visited, stored
    cdef object worth, trail, measured, visit
    cdef Rows rows

    @cython.locals(
        node=int, steps=int, level=double, reach=double, j=int, length=double, rise=double, i=cython.Py_ssize_t,
        target=int, surface=list, occupant=list, holder=list, options=list, lengths=list, chances=list, explored=cython.bint,
    )
    cpdef double depart(self, int agent, now)

    @cython.locals(x=double, y=double, dx=double, dy=double, at=int)
    cdef bint sees_box(self, int node)

    cdef double crowding(self, int node)

    @cython.locals(value=double)
    cdef double nearness(self, int node)

    @cython.locals(took=double)
    cdef double seconds(self, int agent, int i, int j, double length)

    @cython.locals(origin=int, node=int, before=int, level=double)
    cpdef tuple arrive(self, int agent)

    @cython.locals(
        d=list, official=list, surface=list, reach=double, best=double, best_official=double, j=int, length=double, rise=double,
        through=double, value=double,
    )
    cdef update_distance(self, int node, double level)
