# The types of footing.py when it is compiled.
cimport cython

cdef double[::1] _LOOKS_X, _LOOKS_Y, _RISES, _STEPS
cdef int _DIRECTIONS, _DISTANCES, _GROUND, _RAMP
cdef double _FURTHEST, _NOWHERE


cdef class Footing:
    cdef double[::1] _grounds, _ramps
    cdef Py_ssize_t _ground_count, _ramp_count

    @cython.locals(
        grounds=cython.double[::1], ramps=cython.double[::1], k=cython.Py_ssize_t, i=cython.Py_ssize_t, inside=cython.bint, top=double, height=double,
        dx=double, dy=double, c=double, s=double, along=double, across=double, landing=double, length=double,
    )
    cpdef double height(self, double x, double y)

    @cython.locals(
        direction=cython.Py_ssize_t, k=cython.Py_ssize_t, j=cython.Py_ssize_t, here=double, there=double, before=double, slack=double,
    )
    cpdef double slack(self, double x, double y)

    @cython.locals(
        ramps=cython.double[::1], reach=double, k=cython.Py_ssize_t, i=cython.Py_ssize_t, dx=double, dy=double, c=double, s=double, along=double,
        beyond=double, level=double,
    )
    cdef bint _amid(self, double x, double y)

    @cython.locals(g=cython.double[::1])
    cdef bint _within(self, Py_ssize_t i, double margin, double x, double y)
