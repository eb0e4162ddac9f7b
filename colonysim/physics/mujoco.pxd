# The types of mujoco.py when it is compiled.
cimport cython


cdef class MujocoEngine:
    cdef readonly object facts
    cdef object _mj, _spec, _model, _data, _numpy, _advance, _touch
    cdef list _geoms, _qpos_of, _dof_of, _row_of, _pushed
    cdef set _fixed
    cdef dict _nowhere
    cdef Py_ssize_t _bodies
    cdef bint _compiled
    cdef double[::1] _qpos, _qvel, _forces
    cdef double _xx, _xy, _xz, _yx, _yy, _yz, _zx, _zy, _zz

    @cython.locals(at=Py_ssize_t, qpos=double[::1])
    cpdef pose(self, Py_ssize_t body)

    @cython.locals(dof=Py_ssize_t, qvel=double[::1])
    cpdef velocity(self, Py_ssize_t body)

    @cython.locals(
        row=Py_ssize_t, forces=double[::1], fx=double, fy=double, fz=double, ax=double, ay=double, az=double,
        tx=double, ty=double, tz=double,
    )
    cpdef push(self, Py_ssize_t body, force, at, torque)

    @cython.locals(row=Py_ssize_t, forces=double[::1])
    cpdef step(self)

    cpdef Py_ssize_t _place_of(self, Py_ssize_t body) except -1

    @cython.locals(at=Py_ssize_t, qpos=double[::1], w=double, x=double, y=double, z=double)
    cpdef _turn_as(self, Py_ssize_t body)
    cpdef tuple _turned(self, double a, double b, double c)
