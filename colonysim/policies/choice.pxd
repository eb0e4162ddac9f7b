# The types of choice.py when it is compiled.
cimport cython
from colonysim.exact cimport exp

@cython.locals(top=double, total=double, i=int, numbers=cython.bint)
cpdef int weigh(double[::1] values, int count, double beta) except -1

@cython.locals(i=int, last=int)
cpdef int pick(double[::1] chances, int count, double rest) noexcept
