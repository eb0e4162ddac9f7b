# The types of shapes.py when it is compiled.
cimport cython

cdef double _HALF_TURN, _FULL_TURN

cpdef double wrap(double angle)

@cython.locals(x=double, y=double, z=double, w=double, roll=double, pitch=double, yaw=double)
cpdef tuple euler(q)
