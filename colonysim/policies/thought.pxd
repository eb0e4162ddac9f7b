# The types of thought.py when it is compiled.


cdef class Memory:
    cdef readonly double epsilon
    cdef readonly int box, hole, sought, shunned, shunned_at
    cdef readonly tuple way

    cpdef tuple _key(self)


cdef class Thought:
    cdef readonly Memory memory
    cdef public object wait, nodes, boxes, chances
    cdef public int node, box, hole
    cdef public bint explored

    cpdef choice(self)
