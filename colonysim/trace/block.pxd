# What other compiled modules may call of block.pyx.
cimport cython
from cpython cimport array


@cython.final
cdef class _Column:
    cdef int kind
    cdef long long code
    cdef object codes, text
    cdef array.array values, sizes

    cdef start(self)
    cdef int put(self, value) except -1
    cdef int size(self, Py_ssize_t count) except -1


@cython.final
cdef class Block:
    cdef str table
    cdef list names, columns
    cdef readonly Py_ssize_t rows
    cdef Py_ssize_t at

    cpdef append(self, row)
    cdef _Column next(self)
    cdef int whole(self, long long value) except -1
    cdef int real(self, double value) except -1
    cdef int flag(self, bint value) except -1
    cdef int word(self, str value) except -1
    cdef int item(self, long long value) except -1
    cdef int real_item(self, double value) except -1
    cdef int items(self, Py_ssize_t count) except -1
    cdef _back_to(self, Py_ssize_t rows)
