# The types of moments.py when it is compiled.
cimport cython

cdef double NEVER


@cython.final
cdef class Moments:
    cdef readonly double time
    cdef int _count
    cdef double[::1] _times, _orders
    cdef long long[::1] _whats

    cpdef clear(self)
    @cython.locals(times="double[::1]", orders="double[::1]", whats="long long[::1]", place=int, above=int)
    cpdef put(self, double time, double order, long long what)
    @cython.locals(
        times="double[::1]", orders="double[::1]", whats="long long[::1]", place=int, below=int, count=int, time=double,
        order=double, first="long long",
    )
    cpdef long long take(self)
    cdef _grow(self)
