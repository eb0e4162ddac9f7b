# The types of exact.py when it is compiled.
cimport cython

cdef double LOG2_E, LN2_HIGH, LN2_LOW, C2, C3, C4, C5, C6, C7, C8, C9, C10, C11, C12, C13
cdef int DEEPEST
cdef double[::1] POWERS

@cython.locals(k=cython.int, t=double, r=double, tail=double, p=double)
cpdef double exp(double x)
