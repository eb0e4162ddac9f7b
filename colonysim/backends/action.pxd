# The types of action.py when it is compiled.
cimport cython
from colonysim.backends.traffic cimport closing_in, ticks_until_close
from colonysim.physics.scene cimport Scene as SceneType  # action.py has its own Scene, for checking types


@cython.final
cdef class Action:
    cdef public object manoeuvre
    cdef readonly object intent, origin
    cdef readonly bint held
    cdef object _speeds
    cdef Py_ssize_t look_at

    @cython.locals(left=double, right=double, ticks=Py_ssize_t, held=cython.bint)
    cdef go_on(self, SceneType scene, Py_ssize_t agent)


@cython.final
cdef class Actions:
    cdef list _of
    cdef SceneType _scene

    @cython.locals(scene=SceneType, over=list, agent=Py_ssize_t, action=Action)
    cpdef list go_on(self)
