# The types of episode.py when it is compiled.
cimport cython
from colonysim.simulation.strides cimport Strides
from colonysim.simulation.waiting cimport Waiting
from colonysim.world.state cimport World


cdef class Episode:
    cdef public object fields, backend, policy, rows, env, event_number, clock, visit
    cdef public int number
    cdef public World world
    cdef public Strides strides
    cdef public list memories, views, random, steps, queue
    cdef public Waiting waiting
    cdef public dict asks, resting
    cdef double[::1] since
    cdef public set finished
    cdef public double now, last_outcome, stall, limit
    cdef public bint stuck

    cdef _expect(self, long long number, double seconds)
    @cython.locals(strides=Strides, now=double, number="long long")
    cdef _moment(self)
    @cython.locals(strides=Strides, seconds=double)
    cdef _stride(self, int agent)
    cdef _rest(self, int agent, wait)
    cpdef _rouse(self, int agent)
    cdef _rested(self, int agent)
