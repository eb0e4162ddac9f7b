# The types of waiting.py when it is compiled.
cimport cython

cdef int _NOT, _ASLEEP, _CALLED


cdef class Waiting:
    cdef object _rouse
    cdef list _at
    cdef unsigned char[::1] _states
    cdef long long[::1] _waits, _full
    cdef long long _agents, _count

    @cython.locals(wait="long long", waits=list, w="long long", node=cython.Py_ssize_t)
    cpdef long long begin(self, int agent, nodes) except? -1
    cpdef bint waits(self, int agent)
    cpdef end(self, int agent)
    @cython.locals(wait="long long", waits=list, agent=int, found=cython.bint, node=cython.Py_ssize_t)
    cpdef bint wake(self, nodes) except? -1
    cpdef call(self, int agent)
    @cython.locals(agent=int)
    cpdef expire(self, long long wait)
