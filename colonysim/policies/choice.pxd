# The types of choice.py when it is compiled.
cimport cython
from colonysim.exact cimport exp

@cython.locals(top=double, total=double, weight=double, value=double)
cpdef list softmax(values, double beta=*)

@cython.locals(rest=double, probability=double, i=cython.Py_ssize_t, last=cython.Py_ssize_t)
cpdef Py_ssize_t sample(probabilities, random)
