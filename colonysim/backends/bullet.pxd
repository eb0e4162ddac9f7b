# The types of bullet.py when it is compiled.
cimport cython
from colonysim.backends.traffic cimport closing_in, ticks_until_close


cdef class _Action:
    cdef public object manoeuvre
    cdef readonly object intent, origin
    cdef readonly bint held
    cdef Py_ssize_t look_at

    cpdef look_out(self, scene, Py_ssize_t agent, speeds, Py_ssize_t ticks)
