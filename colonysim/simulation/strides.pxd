# The types of strides.py when it is compiled.
cimport cython
from colonysim.draws cimport Draws
from colonysim.pheromones.box cimport BoxWorth
from colonysim.pheromones.exploration cimport Exploration
from colonysim.pheromones.hole cimport HoleTrail
from colonysim.policies.choice cimport pick, weigh
from colonysim.policies.stigmergy cimport Stigmergy
from colonysim.policies.thought cimport Memory, Thought
from colonysim.policies.view cimport LocalView
from colonysim.trace.rows cimport Rows
from colonysim.world.sight cimport Sight
from colonysim.world.state cimport World

cdef double UNKNOWN


@cython.final
cdef class Strides:
    cdef int goal
    cdef long long max_steps
    cdef double reach, d_max, scale, shift, beta, fixed, pace, push_fixed, push_pace, jitter
    cdef bint lrta, blank, marks_waits, marks_starts, plain
    cdef int[::1] first, ends, occupant, node_holder, agent_node, agent_from, agent_box, steps, target, ways, options
    cdef int[::1] box, hole, ends_at, hole_at
    cdef double[::1] box_base, lengths, rises, surface, d, straight, stored, epsilon, began, chances
    cdef unsigned char[::1] official, known, visited, moved
    cdef Draws draws
    cdef list reserved, memories, views, draw
    cdef dict clear_requests, handed, asks
    cdef object travels, pushes, visit, withdraw
    cdef object backend
    cdef BoxWorth worth
    cdef Exploration exploration
    cdef World world
    cdef Stigmergy policy
    cdef HoleTrail trail
    cdef Rows rows
    cdef Sight sight

    @cython.locals(agent=int, memory=Memory)
    cpdef prepare(self, list memories, list random)

    @cython.locals(node=int, seconds=double, memory=Memory)
    cpdef double depart(self, int agent, double now) except? -1

    @cython.locals(
        level=double, reach=double, way=int, j=int, target=int, count=int, chosen=int, surface="double[::1]",
        occupant="int[::1]", holder="int[::1]", ends="int[::1]", options="int[::1]", explored=cython.bint,
    )
    cdef double stroll(self, int agent, int node, double now) except? -1

    @cython.locals(
        view=LocalView, world=World, thought=Thought, target=int, box=int, level=double, ends_at=int, pushed=cython.bint,
        possible=cython.bint, base=double, way=int,
    )
    cdef double think(self, int agent, int node, double now) except? -1

    cdef int way(self, int node, int target)
    cdef begin(self, int agent, int target, double now)
    cpdef Thought handed_back(self, int agent)
    @cython.locals(view=LocalView)
    cdef tell(self, int agent)

    @cython.locals(i=int, chances="double[::1]", options="int[::1]")
    cdef int choose(self, int count, bint explored, double rest)

    cdef double crowding(self, int node)

    @cython.locals(value=double)
    cdef double nearness(self, int node)

    @cython.locals(took=double)
    cdef double seconds(self, int agent, int i, int j, double length, bint pushed) except? -1

    cpdef int heading(self, int agent)
    @cython.locals(origin=int, target=int, before=int)
    cpdef int arrive(self, int agent) except? -2

    @cython.locals(ends_at=int)
    cdef push(self, int agent, int box, int origin, int target, int before)

    @cython.locals(
        node=int, held=int, level=double, stays=cython.bint, marks=cython.bint, rows=Rows,
    )
    cpdef mark(self, str moment, int agent, int box, int hole, int left, int before)

    @cython.locals(value=double, credited=list)
    cdef mark_boxes(self, BoxWorth worth, str moment, int agent, int node, int box, int hole, int left, int before)

    @cython.locals(
        d="double[::1]", official="unsigned char[::1]", surface="double[::1]", reach=double, best=double, best_official=double,
        way=int, j=int, through=double, value=double,
    )
    cdef update_distance(self, int node, double level)
