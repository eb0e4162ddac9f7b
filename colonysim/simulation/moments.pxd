# The types of moments.py when it is compiled.
cimport cython

cdef double NEVER


@cython.final
cdef class Moments:
    cdef readonly double time
    cdef readonly long long number
    cdef int _count
    cdef double[::1] _times
    cdef long long[::1] _numbers, _whats

    cpdef clear(self)
    @cython.locals(times="double[::1]", numbers="long long[::1]", whats="long long[::1]", place=int, above=int)
    cpdef void put(self, double time, long long number, long long what)
    @cython.locals(
        times="double[::1]", numbers="long long[::1]", whats="long long[::1]", place=int, below=int, count=int, time=double,
        number="long long", first="long long",
    )
    cpdef long long take(self)
    cdef _grow(self)
