# The types of sensing.py when it is compiled.
cimport cython
from colonysim.draws cimport Draws as Drawn, Keyed

cdef unsigned long long OF_BOXES, OF_NODES, OF_MARKS
cdef double BITS


@cython.final
cdef class Senses:
    cdef readonly bint misses, misplaces, misreads
    cdef readonly double[::1] true_x, true_y, x, y, lengths
    cdef public Drawn looks
    cdef double _missed, _spread, _noise, _second
    cdef Keyed _errors

    cpdef unsigned long long look(self, int agent) except? 1
    cpdef decided(self, int agent)
    cpdef bint overlooks(self, unsigned long long look, int box) except? -1
    @cython.locals(east=double, north=double)
    cpdef place(self, unsigned long long look, int node, bint exact)
    @cython.locals(factor=double)
    cpdef double factor(self, unsigned long long look, unsigned long long field, int node, int key) except? -1
    @cython.locals(square=double, one=double, other=double, wide=double, errors=Keyed)
    cdef double _normal(self) except? -1

