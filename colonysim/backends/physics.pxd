# The types of physics.py when it is compiled.
cimport cython
from colonysim.backends.action cimport Actions
from colonysim.physics.scene cimport Scene as SceneType  # physics.py makes its own Scene, which tests may replace


cdef class Physics:
    cdef public bint recording
    cdef readonly object tick
    cdef double _metre
    cdef Py_ssize_t _pose_ticks
    cdef readonly object engine, push, feasibility, edge_seconds
    cdef readonly SceneType _scene
    cdef readonly Actions _actions
    cdef readonly object _world, _layout
    cdef object _gui, _execute, _forest, _way_chance, _laid_out, _streams, _traffic, _now, _pushes
    cdef list _rows

    @cython.locals(scene=SceneType, finished=list)
    cpdef advance(self, now)

    cpdef SceneType _open(self)

    @cython.locals(metre=double)
    cdef _in_metres(self, pose)

    @cython.locals(scene=SceneType, rows=list)
    cdef _record_movers(self)
