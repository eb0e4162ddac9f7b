# The types of box.py when it is compiled.
from colonysim.pheromones.marks cimport Marks


cdef class BoxWorth(Marks):
    cdef public object _world
    cdef public double _start, _decay, _cap
    cdef public bint _on_entry, _whole_stack
    cdef dict _worth

    cpdef double at(self, int node, int key=*) except? -1
