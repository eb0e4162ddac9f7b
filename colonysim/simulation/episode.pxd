# The types of episode.py when it is compiled.
cimport cython
from colonysim.backends.motion cimport Motion as MotionType
from colonysim.draws cimport Draws
from colonysim.pheromones.field cimport Visit
from colonysim.pheromones.marks cimport Marks
from colonysim.policies.decision cimport Decider, Decision, Options, Stream as Drawn, new_decision
from colonysim.policies.view cimport LocalView
from colonysim.simulation.alarms cimport Alarm
from colonysim.simulation.waiting cimport Waiting
from colonysim.trace.rows cimport Rows
from colonysim.world.visibility cimport Visibility
from colonysim.world.state cimport World

cdef double ENDS, WOKEN, MOVED, SHORTEST_WAIT, ENOUGH, SELDOM, SHORT_WAIT
cdef int TOLERATED, DOUBLINGS, DECISIONS, RESTING, ACTING, STANDING


cdef class Episode


cdef class Process(Alarm):
    cdef Episode _episode
    cdef int _agent

    @cython.locals(episode=Episode)
    cpdef come(self, event)


@cython.final
cdef class Episode:
    cdef public object rows, fields, backend, env, clock, timers, ticks, timeline
    cdef public Decider policy
    cdef public MotionType motion
    cdef public World world
    cdef public Draws ties
    cdef public Visit visit
    cdef public Waiting waiting
    cdef public list memories, views, random, processes, marks, unmarked, outcomes
    cdef public set finished, short
    cdef public long long number, acting, standing, armed, timed, max_steps, stepped, pause_at, slice
    cdef public double now, due, last_outcome, stall, limit, edge_seconds, wall
    cdef public bint stuck, over, synchronous, clocked, awaited, paused, outside
    cdef public int asked
    cdef readonly unsigned char[::1] doing, expires
    cdef readonly int[::1] asks, target, box, hole, ends_at, short_waits, spins
    cdef readonly double[::1] began, since, leaves
    cdef public double[::1] still_until
    cdef public object faults
    cdef public bint alike, stops, loses, breaks
    cdef unsigned char[::1] pushes
    cdef double[::1] speeds
    cdef readonly long long[::1] steps

    @cython.locals(view=LocalView, agent=int)
    cpdef prepare(self, number, memories, streams, synchronous)
    cdef _seed(self, streams)
    @cython.locals(rows=Rows, agents=cython.Py_ssize_t, due=double)
    cpdef bint go_on(self, double until=*) except? -1
    @cython.locals(rows=Rows)
    cpdef bint goes_on(self, double due) except? -1
    cdef bint _anything_due(self) except? -1
    cdef bint _stalls(self, double due) except? -1
    @cython.locals(node=int)
    cdef _withdraw_request(self, int agent)
    @cython.locals(rested=cython.bint)
    cpdef resume(self, int agent)
    cdef _choose(self, int agent)
    cpdef ask(self, int agent)
    @cython.locals(agent=int)
    cpdef answer(self, Decision decision)
    cdef _follow(self, int agent, Decision decision)
    @cython.locals(process=Process)
    cdef _expect(self, int agent, double seconds, double order)
    @cython.locals(world=World)
    cpdef bint done(self, int agent) except? -1
    @cython.locals(view=LocalView, decision=Decision, stream=Drawn)
    cpdef Decision decide(self, int agent)
    @cython.locals(view=LocalView, rows=Rows, options=Options)
    cdef _note(self, int agent, Decision decision)
    cdef _look_again(self, LocalView view, Decision decision)
    @cython.locals(world=World, node=int)
    cpdef reserve(self, int agent, Decision decision)
    @cython.locals(view=LocalView)
    cpdef count_step(self, int agent)
    @cython.locals(node=int, box=int, hole=int, seconds=double)
    cpdef act(self, int agent, Decision decision)
    @cython.locals(motion=MotionType, at=int, fails=cython.bint, seconds=double)
    cdef double _undertake(self, int agent, int node, int box, int hole) except? -2
    @cython.locals(
        world=World, view=LocalView, rows=Rows, node=int, box=int, hole=int, origin=int, before=int, action=str, status=str, reason=str,
        lost=cython.bint, now_at=int,
    )
    cpdef bint settle(self, int agent) except? -1
    cpdef stand_still(self, int agent, double until)
    @cython.locals(seconds=double)
    cdef _stand(self, int agent)
    @cython.locals(until=double)
    cpdef stop_by_chance(self, int agent, bint rested)
    @cython.locals(rows=Rows, node=int)
    cpdef note_stop(self, int agent)
    @cython.locals(world=World, rows=Rows, visibility=Visibility, count=int, clear=int)
    cdef _rest(self, int agent, wait)
    @cython.locals(short=cython.bint, more=int, seconds=double)
    cdef double _length(self, int agent, double asked) except? -1
    cpdef _rouse(self, int agent)
    @cython.locals(view=LocalView)
    cdef _rested(self, int agent)
    @cython.locals(rows=Rows)
    cpdef note_wait(self, int agent, nodes)
    @cython.locals(world=World, visit=Visit, rows=Rows, some=list, marks=Marks, count=int)
    cdef _deposit(self, str moment, int agent, int box=*, int hole=*, int left=*, int before=*)
