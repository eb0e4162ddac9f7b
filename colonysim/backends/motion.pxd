# The types of motion.py when it is compiled.


cdef class Motion:
    cdef public object outcome
    cdef public int ends_at

    cpdef needs(self, int agent, int node, int box, int hole)
    cpdef double undertake(self, int agent, int node, int box, int hole, double now) except? -2
