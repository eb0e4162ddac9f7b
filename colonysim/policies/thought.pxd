# The types of thought.py when it is compiled.
cimport cython


# Neither can be part of a cycle: the garbage collector need not look at them.
@cython.no_gc
@cython.freelist(64)
cdef class Memory:
    # In the order of the file: the compiled class takes its arguments as they stand here.
    cdef public double epsilon
    cdef public int box, hole
    cdef public tuple way
    cdef public int sought, shunned, shunned_at, vain


@cython.locals(memory=Memory)
cpdef Memory remembering(double epsilon, int box, int hole, tuple way, int sought, int shunned, int shunned_at, int vain)


@cython.final
cdef class Options:
    cdef readonly int[::1] nodes, boxes
    cdef readonly double[::1] chances


@cython.final
@cython.no_gc
@cython.freelist(64)
cdef class Thought:
    cdef public Memory memory
    cdef public object wait
    cdef public int node, box, hole, count
    cdef public bint explored, idle
    cdef public Options options

    cpdef intent(self, view)
    @cython.locals(options=Options)
    cpdef choice(self, view)


@cython.locals(thought=Thought)
cpdef Thought thinking(Memory memory)
