# The types of learned.py when it is compiled.
cimport cython
from colonysim.physics.scene cimport Scene
from colonysim.physics.shapes cimport wrap
from colonysim.push.controls cimport control_speeds
from colonysim.push.driving cimport Pilot
from colonysim.push.state cimport observe


cdef class _NetworkPart:
    cdef Pilot _pilot
    cdef object _task, _choose, _state
    cdef Py_ssize_t _ticks
    cdef double _tolerance, _started_at

    cdef _look(self)

    @cython.locals(scene=Scene, robot=Py_ssize_t)
    cdef _verdict(self)


cdef _look(Scene scene, Py_ssize_t robot, task)
