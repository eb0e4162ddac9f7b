# The types of rows.py when it is compiled.
cimport cython
from colonysim.trace.block cimport Block
from colonysim.trace.writer cimport TraceWriter


cdef class Rows:
    cdef long long _episode
    cdef object _write, _kinds
    cdef bint _decisions
    cdef tuple _holes
    cdef long long[::1] _numbers
    cdef Block _ended, _chosen, _marked
    cdef TraceWriter _writer
    cdef public list events
    cdef readonly bint kept, hears_ends, hears_waits
    cdef public double now

    cdef bint _heard(self, str kind)
    cpdef event(
        self, kind, agent=*, action=*, Py_ssize_t node=*, Py_ssize_t target=*, box=*, Py_ssize_t hole=*, status=*,
        reason=*, step=*, began=*, now_at=*,
    )
    cpdef decision(self, agent, Py_ssize_t node, explored, Py_ssize_t chosen, targets, boxes, probabilities)

    @cython.locals(block=Block)
    cpdef travelled(self, int agent, Py_ssize_t origin, Py_ssize_t node, int step, double began)

    @cython.locals(block=Block, i=cython.Py_ssize_t)
    cpdef chose(
        self, int agent, Py_ssize_t node, bint explored, Py_ssize_t chosen, int[::1] targets,
        double[::1] probabilities, Py_ssize_t count,
    )

    @cython.locals(block=Block)
    cpdef deposit(self, str name, int agent, Py_ssize_t node, double value)

    cdef _settle(self, str table, Block block)
