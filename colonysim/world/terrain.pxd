# The types of terrain.py when it is compiled.
cimport cython


@cython.final
cdef class Terrain:
    cdef readonly int[::1] first, ends
    cdef readonly double[::1] lengths, rises
    cdef readonly double[::1] surface
    cdef readonly double reach
    cdef readonly int size
    cdef double _slack
    cdef unsigned char[::1] _forbidden
    cdef object _topology, _slopes, _absent

    @cython.locals(edge=int)
    cpdef int edge(self, int i, int j) except? -2
    cdef bint is_level(self, double difference) noexcept
    cdef bint leads(self, double level, int edge) noexcept
    cdef bint slides(self, double base, int edge) noexcept
    cdef bint falls(self, double base, int edge) noexcept
