# The types of choice.py when it is compiled.
cimport cython
from colonysim.exact cimport exp

@cython.locals(top=double, total=double, i=int)
cpdef void weigh(double[::1] values, int count, double beta) noexcept

@cython.locals(i=int, last=int)
cpdef int pick(double[::1] chances, int count, double rest) noexcept
