# The types of thought.py when it is compiled.


cdef class Thought:
    cdef readonly object memory
    cdef public object wait, nodes, boxes, chances
    cdef public int node, box, hole
    cdef public bint explored

    cpdef intent(self)
    cpdef choice(self)
