# The types of field.py when it is compiled.
cimport cython


@cython.final
cdef class Visit:
    # In the order of the file: the compiled class takes its arguments as they stand here.
    cdef public str moment
    cdef public int agent, node
    cdef public double level
    cdef public int box, hole, left, before
    cdef public double mark
