# The types of episode.py when it is compiled.
cimport cython
from colonysim.draws cimport Draws
from colonysim.policies.thought cimport Thought
from colonysim.policies.view cimport LocalView
from colonysim.simulation.moments cimport Moments
from colonysim.simulation.strides cimport Strides
from colonysim.simulation.waiting cimport Waiting
from colonysim.trace.rows cimport Rows
from colonysim.world.sight cimport Sight
from colonysim.world.state cimport World

cdef double ENDS, WOKEN, MOVED, SHORTEST_WAIT, ENOUGH, SELDOM, SHORT_WAIT
cdef int TOLERATED, DOUBLINGS, DECISIONS


cdef class Episode:
    cdef public object fields, backend, policy, env, clock, visit
    cdef public int number, striding
    cdef public World world
    cdef public object rows
    cdef public Strides strides
    cdef public Moments moments
    cdef public Draws ties
    cdef public list memories, views, random, queue
    cdef public object steps
    cdef public Waiting waiting
    cdef public dict asks, told, outcomes
    cdef double[::1] since
    cdef int[::1] short_waits, spins
    cdef public set finished, short
    cdef public double now, due, last_outcome, stall, limit
    cdef public bint stuck, asked_for_strides
    cdef public int goal
    cdef public long long max_steps

    @cython.locals(
        queue=list, moments=Moments, rows=Rows, events=list, agents=cython.Py_ssize_t, due=double, told=cython.bint, time=double,
    )
    cdef bint _go_on(self) except? -1
    cdef bint _stalls(self, double due) except? -1
    @cython.locals(views=list, view=LocalView, edge_seconds=double)
    cdef _prepare(self, number, memories, streams, synchronous)
    cdef _expect(self, int agent, double seconds, double order)
    @cython.locals(strides=Strides, number="long long", origin=int, target=int)
    cdef _moment(self)
    @cython.locals(strides=Strides, seconds=double, thought=Thought)
    cdef _stride(self, int agent)
    cdef _rest(self, int agent, wait)
    cpdef _rouse(self, int agent)
    @cython.locals(view=LocalView)
    cdef _rested(self, int agent)
    @cython.locals(sight=Sight, node=int, count=int, rows=Rows)
    cdef _idle(self, int agent)
    cpdef _deposit(self, str moment, int agent, int box=*, int hole=*, int left=*, int before=*)
