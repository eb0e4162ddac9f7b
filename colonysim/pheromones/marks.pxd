# The types of marks.py when it is compiled.
cimport cython
from colonysim.pheromones.field cimport Visit
from colonysim.exact cimport exp
from colonysim.world.state cimport World

cdef double LN2, LEAST_LEFT


@cython.final
cdef class Fading:
    cdef World _world
    cdef readonly bint on
    cdef readonly object half_life
    cdef readonly double rate, since
    cdef double _asked, _answer

    cpdef double age(self)
    @cython.locals(now=double)
    cpdef double left(self)
    cpdef double left_at(self, double second)
    cpdef bint faint(self)
    cpdef bint faint_at(self, double second)
    cpdef restart(self, double second)


cdef class Marks:
    cdef int _wrote
    cdef int[::1] _places, _keys
    cdef double[::1] _values

    cpdef double at(self, int node, int key=*) except? -1
    cpdef keys(self, int node)
    cpdef int gather(self, int node, int[::1] found, int count, unsigned char[::1] marked) except -1
    cpdef int mark(self, Visit visit) except -1
    cpdef int place(self, int i) except? -1
    cpdef int key(self, int i) except? -1
    cpdef double value(self, int i) except? -1
    cpdef wipe(self, nodes)
    cpdef settle(self)
    @cython.locals(i=int)
    cdef int _note(self, int place, int key, double value) except -1


cpdef list each_node(nodes, int size)


@cython.locals(key=int)
cpdef int gather_keys(keys, int[::1] found, int count, unsigned char[::1] marked) except -1
