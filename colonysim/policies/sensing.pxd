# The types of sensing.py when it is compiled.
cimport cython
from colonysim.draws cimport Draws as Drawn

cdef unsigned long long ALL, STEP, FIRST, SECOND, OF_BOXES, OF_NODES, OF_MARKS
cdef double UNIT, BITS


@cython.final
cdef class Senses:
    cdef readonly bint misses, misplaces, misreads
    cdef readonly double[::1] true_x, true_y, x, y, lengths
    cdef public Drawn looks
    cdef double _missed, _spread, _noise, _second
    cdef unsigned long long _state

    cpdef unsigned long long look(self, int agent) except? 1
    cpdef bint overlooks(self, unsigned long long look, int box) except? -1
    @cython.locals(east=double, north=double)
    cpdef place(self, unsigned long long look, int node, bint exact)
    @cython.locals(factor=double)
    cpdef double factor(self, unsigned long long look, unsigned long long field, int node, int key) except? -1
    @cython.locals(state="unsigned long long")
    cdef void _begin(self, unsigned long long look, unsigned long long one, unsigned long long other)
    cdef double _uniform(self)
    @cython.locals(square=double, one=double, other=double, wide=double)
    cdef double _normal(self) except? -1


cdef unsigned long long _mixed(unsigned long long z)
