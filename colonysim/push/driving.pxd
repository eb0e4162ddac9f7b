# The types of driving.py when it is compiled.
cimport cython
from colonysim.physics.traction cimport wheel_speeds
from colonysim.physics.scene cimport Scene, ticks_to_close
from colonysim.physics.shapes cimport wrap

cdef double _TURN_RATE, _CURVE, _TURN_START, _TURN_STOP, _LOOK_AHEAD, _STALL_SECONDS, _CLOSE, _ASIDE, _IN_THE_WAY
cdef int _FAULT_TICKS, _GUARD_TICKS, _HOLD_TICKS


@cython.final
cdef class Pilot:
    cdef readonly Scene scene
    cdef readonly Py_ssize_t robot
    cdef readonly double begun, deadline
    cdef object _log, _chooser, _control
    cdef Py_ssize_t _ticks

    @cython.locals(same=cython.bint)
    cpdef note(self, control, chooser=*)
    cpdef fault(self)
    cpdef flush(self)


@cython.final
cdef class _Lookout:
    cdef Scene _scene
    cdef Py_ssize_t _robot, _look_at
    cdef object _obstacles

    @cython.locals(x=double, y=double, nearest=double, u=double, v=double, there=double, away=double, i=Py_ssize_t)
    cpdef bint blocked(self, ahead)


@cython.final
cdef class _Waypoint:
    cdef Scene _scene
    cdef Py_ssize_t _robot
    cdef double _x, _y, _near, _speed, _best, _since, _here_x, _here_y, _distance, _error
    cdef bint _last, _turning

    @cython.locals(x=double, y=double, yaw=double, dx=double, dy=double, distance=double, error=double)
    cdef bint reached(self)

    @cython.locals(distance=double, now=double)
    cdef bint stalled(self)

    @cython.locals(share=double, x=double, y=double)
    cdef tuple ahead(self)

    cdef control(self)

    @cython.locals(error=double, forward=double, turn=double)
    cdef speeds(self)
