# The types of learned.py when it is compiled.
cimport cython
from colonysim.physics.shapes cimport wrap
from colonysim.push.controls cimport control_speeds
from colonysim.push.driving cimport Pilot
from colonysim.push.state cimport observe


@cython.final
cdef class ControlLoop:
    cdef readonly object state
    cdef Pilot _pilot
    cdef object _task, _rules
    cdef Py_ssize_t _ticks, _check_every
    cdef double _started_at, _bumper

    cdef _look(self)
    cdef _over(self)
