# The types of scene.py when it is compiled.
cimport cython
from colonysim.physics.traction cimport Traction
from colonysim.physics.shapes cimport euler

cdef double _CLOSER_IN_A_TICK, _ENDLESS
cdef int _FLIPPED_TICKS

cpdef int ticks_to_close(double gap)


cdef class Scene:
    cdef readonly object terrain, _engine
    cdef readonly tuple boxes, models, _present, _robots
    cdef readonly Py_ssize_t ticks
    cdef readonly double time
    cdef readonly list _boxes, _tractions, _tilted
    cdef double _bottom, _safe
    cdef dict _box_poses, _seated
    cdef object _open_pits, _standing

    cpdef drive(self, Py_ssize_t robot, double left, double right)

    @cython.locals(tractions=list, traction=Traction, i=Py_ssize_t)
    cpdef tick(self)

    cpdef robot(self, Py_ssize_t i)
    cpdef tuple course(self, Py_ssize_t i)
    cpdef box(self, Py_ssize_t i)

    @cython.locals(
        x=double, y=double, z=double, pitch=double, yaw=double, c=double, s=double, dip=double, lowest=double, reach=double,
        tilted=int,
    )
    cpdef robot_fault(self, Py_ssize_t i)

    @cython.locals(x=double, y=double, z=double, roll=double, pitch=double, yaw=double)
    cpdef box_fault(self, Py_ssize_t i)
    cpdef tuple present_robots(self)
    cdef _forget(self)
    cpdef Traction _traction(self, Py_ssize_t i)
