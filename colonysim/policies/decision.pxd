# The types of decision.py when it is compiled.
cimport cython
from colonysim.policies.view cimport LocalView


cdef class Memory:
    # In the order of the file: the compiled class takes its arguments as they stand here.
    cdef public double epsilon
    cdef public int box, hole
    cdef public tuple way
    cdef public int sought, shunned, shunned_at, vain


@cython.locals(memory=Memory)
cpdef Memory new_memory(double epsilon, int box, int hole, tuple way, int sought, int shunned, int shunned_at, int vain)


@cython.final
cdef class Options:
    cdef readonly int[::1] nodes, boxes
    cdef readonly double[::1] chances


@cython.final
cdef class Decision:
    cdef public object memory, wait, choice
    cdef public int node, box, hole, count
    cdef public bint explored, idle
    cdef public double mark
    cdef public Options options

    cpdef intent(self, view)
    cpdef waits(self, view)
    @cython.locals(options=Options)
    cpdef as_choice(self, view)


@cython.locals(decision=Decision)
cpdef Decision new_decision(memory)


@cython.final
cdef class Stream:
    cdef readonly object generator, draw


cdef class Decider:
    cpdef Decision think(self, LocalView view, memory, Stream stream)
