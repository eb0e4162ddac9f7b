# The types of clock.py when it is compiled.


cdef class Clock:
    cdef object _env, _backend, _latest, _goes_on, _ended, _wanted
    cdef dict _pending

    cdef tuple _advance(self, double now, double tick, double due, double last)
