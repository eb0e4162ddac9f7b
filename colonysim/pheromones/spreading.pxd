# The types of spreading.py when it is compiled.
cimport cython
from colonysim.pheromones.marks cimport Fading, each_node
from colonysim.world.state cimport World

cdef double FAINT, SMALLEST_SCALE
cdef int LONGEST_LOG, END


@cython.final
cdef class NodeValues:
    cdef World _world
    cdef readonly Fading fading
    cdef readonly object diffusion
    cdef readonly double period, scale
    cdef readonly long long ticks
    cdef readonly double[::1] held
    cdef bint _spreads
    cdef int _size, _count, _logged
    cdef int[::1] _first, _ends, _active, _nodes
    cdef double[::1] _portions, _next, _seconds, _amounts
    cdef unsigned char[::1] _listed

    @cython.locals(twin=NodeValues)
    cpdef __deepcopy__(self, memo)
    @cython.locals(value=double)
    cpdef double at(self, int node) except? -1
    cpdef add(self, int node, double amount)
    cpdef put(self, int node, double value)
    @cython.locals(node=int)
    cpdef wipe(self, nodes)
    cpdef end_episode(self, double keep=*)
    @cython.locals(node=int)
    cpdef list items(self)
    @cython.locals(i=int, node=int, second=double, amount=double)
    cpdef int settle(self) except -1
    cdef int _check(self, int node) except -1
    @cython.locals(i=int)
    cdef int _write_down(self, double second, int node, double amount) except -1
    @cython.locals(one=double)
    cdef int _add(self, double second, int node, double amount) except -1
    cdef int _renew(self, double second) except -1
    @cython.locals(node=int)
    cdef int _rescale(self) except -1
    @cython.locals(node=int, least=double)
    cdef int _end(self, double second, double keep) except -1
    cdef int _clear(self) except -1
    @cython.locals(due="long long")
    cdef int _spread(self, double second) except -1
    @cython.locals(
        changed=cython.bint, rises="double[::1]", factor=double, least=double, k=int, i=int, j=int, edge=int, own=double,
        other=double, rise=double, fresh=double, strong=cython.bint, takes_part=cython.bint, edges=int, others=int,
        count=int,
    )
    cdef bint _tick(self) except? -1
