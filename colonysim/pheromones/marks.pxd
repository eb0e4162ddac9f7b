# The types of marks.py when it is compiled.


cdef class Marks:
    cpdef double at(self, int node, int key=*) except? -1
    cpdef keys(self, int node)
