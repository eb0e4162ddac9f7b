# The types of waiting.py when it is compiled.
cimport cython


cdef class Waiting:
    cdef readonly dict events
    cdef dict _at, _full
    cdef long long[::1] _waits
    cdef long long _agents

    @cython.locals(wait="long long", waits=list, w="long long")
    cpdef begin(self, int agent, nodes, event)
    cpdef end(self, int agent)
    @cython.locals(wait="long long", waits=list, agent=int)
    cpdef bint wake(self, nodes) except? -1
    cpdef call(self, int agent)
