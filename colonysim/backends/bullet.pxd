# The types of bullet.py when it is compiled.
cimport cython
from colonysim.backends.traffic cimport closing_in, ticks_until_close
from colonysim.physics.scene cimport Scene as SceneType  # the name Scene stays free to be replaced


cdef class _Action:
    cdef public object manoeuvre
    cdef readonly object intent, origin
    cdef readonly bint held
    cdef Py_ssize_t look_at

    @cython.locals(left=double, right=double)
    cpdef go_on(self, SceneType scene, Py_ssize_t agent, Py_ssize_t ticks)
