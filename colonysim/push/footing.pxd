# The types of footing.py when it is compiled.
cimport cython

cdef double[::1] _LOOKS_X, _LOOKS_Y, _RISES, _STEPS
cdef int _DIRECTIONS, _DISTANCES, _GROUND, _RAMP
cdef double _FURTHEST, _NOWHERE


@cython.final
cdef class Footing:
    cdef double[::1] _grounds, _ramps
    cdef int[::1] _all_grounds, _all_ramps, _near_grounds, _near_ramps

    @cython.locals(grounds="int[::1]", ramps="int[::1]")
    cpdef double height(self, double x, double y)

    @cython.locals(
        grounds="double[::1]", ramps="double[::1]", k=cython.Py_ssize_t, i=int, inside=cython.bint, top=double, height=double,
        dx=double, dy=double, c=double, s=double, along=double, across=double, landing=double, length=double,
    )
    cdef double _top(
        self, double x, double y, int[::1] some_grounds, Py_ssize_t ground_count, int[::1] some_ramps, Py_ssize_t ramp_count
    )

    @cython.locals(
        grounds="int[::1]", ramps="int[::1]", ground_count=cython.Py_ssize_t, ramp_count=cython.Py_ssize_t, i=int,
        direction=cython.Py_ssize_t, k=cython.Py_ssize_t, j=cython.Py_ssize_t, here=double, there=double, before=double, slack=double,
    )
    cpdef double slack(self, double x, double y)

    @cython.locals(k=cython.Py_ssize_t, i=int, level=double)
    cdef bint _amid(self, double x, double y)

    @cython.locals(g="double[::1]")
    cdef bint _within(self, int i, double margin, double x, double y)

    @cython.locals(
        ramps="double[::1]", dx=double, dy=double, c=double, s=double, along=double, beyond=double,
    )
    cdef bint _beside_ramp(self, int i, double x, double y)
