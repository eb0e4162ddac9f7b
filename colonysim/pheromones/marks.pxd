# The types of marks.py when it is compiled.
cimport cython


cdef class Marks:
    cpdef double at(self, int node, int key=*) except? -1
    cpdef keys(self, int node)
    cpdef int gather(self, int node, int[::1] found, int count, unsigned char[::1] marked) except -1


@cython.locals(key=int)
cpdef int gather_keys(keys, int[::1] found, int count, unsigned char[::1] marked) except -1
