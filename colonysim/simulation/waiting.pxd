# The types of waiting.py when it is compiled.
cimport cython

cdef int NOTHING, _NOT, _ASLEEP, _CALLED


@cython.final
cdef class Waiting:
    cdef object _rouse
    cdef int[::1] _first, _last, _long, _full, _next
    cdef unsigned char[::1] _states
    cdef long long[::1] _waits, _wait
    cdef long long _agents, _count
    cdef int _used, _spare

    @cython.locals(agent=int, node=int)
    cpdef clear(self)
    @cython.locals(wait="long long", node=cython.Py_ssize_t)
    cpdef long long begin(self, int agent, nodes) except *
    @cython.locals(wait="long long", i=int)
    cpdef begin_at(self, int agent, int[::1] nodes, int count)
    cdef long long _begin(self, int agent)
    @cython.locals(entry=int)
    cdef _add(self, int node, long long wait)
    @cython.locals(entry=int, before=int, after=int, wait="long long")
    cdef _sweep(self, int node)
    cpdef bint waits(self, int agent)
    cpdef end(self, int agent)
    @cython.locals(found=cython.bint, node=cython.Py_ssize_t)
    cpdef bint wake(self, nodes) except? -1
    @cython.locals(found=cython.bint)
    cpdef bint wake_two(self, int one, int other) except? -1
    @cython.locals(wait="long long", entry=int, agent=int, found=cython.bint)
    cdef bint _wake_at(self, int node) except? -1
    cpdef call(self, int agent)
    @cython.locals(agent=int)
    cpdef expire(self, long long wait)
