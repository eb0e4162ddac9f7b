# The types of waiting.py when it is compiled.
cimport cython

cdef int _NOT, _ASLEEP, _CALLED


@cython.final
cdef class Waiting:
    cdef object _rouse
    cdef list _at
    cdef unsigned char[::1] _states
    cdef long long[::1] _waits, _full
    cdef long long _agents, _count

    @cython.locals(wait="long long", waits=list, w="long long", node=cython.Py_ssize_t)
    cpdef long long begin(self, int agent, nodes) except *
    cpdef bint waits(self, int agent)
    cpdef end(self, int agent)
    @cython.locals(found=cython.bint, node=cython.Py_ssize_t)
    cpdef bint wake(self, nodes) except? -1
    @cython.locals(found=cython.bint)
    cpdef bint wake_two(self, Py_ssize_t one, Py_ssize_t other) except? -1
    @cython.locals(wait="long long", waits=list, agent=int, found=cython.bint)
    cdef bint _wake_at(self, Py_ssize_t node) except? -1
    cpdef call(self, int agent)
    @cython.locals(agent=int)
    cpdef expire(self, long long wait)
