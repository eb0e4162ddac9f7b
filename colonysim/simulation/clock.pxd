# The types of clock.py when it is compiled.
cimport cython
from colonysim.simulation.alarms cimport Alarm

cdef double CLOCK
cdef int _IDLE, _CALLED, _TICKING, _TOLD


cdef class Clock(Alarm):
    cdef object _env, _backend, _latest, _goes_on, _ended, _finished
    cdef dict _pending
    cdef int _phase
    cdef double _tick

    @cython.locals(now=double, reached=double)
    cpdef come(self, event)
    cdef _begin_tick(self, double now)
    cdef tuple _advance(self, double now, double due, double last)
