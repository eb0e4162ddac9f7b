# The types of draws.py when it is compiled.
cimport cython

cdef unsigned long long ALL, STEP, FIRST, SECOND
cdef double UNIT


@cython.final
cdef class Draws:
    cdef unsigned long long[::1] _states

    @cython.locals(state="unsigned long long")
    cpdef double draw(self, Py_ssize_t i) except? -1
    cpdef double ahead(self, Py_ssize_t i) except? -1


@cython.final
cdef class Keyed:
    cdef unsigned long long _state

    @cython.locals(state="unsigned long long")
    cpdef void begin(self, unsigned long long one, unsigned long long two, unsigned long long three)
    cpdef double draw(self)


@cython.locals(draws=Draws)
cpdef Draws _resumed(states)
cdef unsigned long long _mixed(unsigned long long z)
