# The types of alarms.py when it is compiled.
cimport cython

cdef double _OFF


cdef class Alarm:
    cdef object _event
    cdef list _callbacks
    cdef double _due, _order

    cpdef come(self, event)
    cpdef arm(self, env, double now, double seconds, double order)
    cpdef reset(self)


@cython.final
cdef class Timer(Alarm):
    cdef object _timers
    cdef public long long wait


@cython.final
cdef class Timers:
    cdef object _expired
    cdef list _made, _idle
