# The types of exploration.py when it is compiled.
from colonysim.pheromones.marks cimport Marks


cdef class Exploration(Marks):
    cdef public object _world
    cdef object _keep, _silent
    cdef public object stored, visited
    cdef public double scale, shift

    cpdef double at(self, int node, int key=*) except? -1
