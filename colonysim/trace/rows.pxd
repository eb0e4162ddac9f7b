# The types of rows.py when it is compiled.
cimport cython
from colonysim.pheromones.marks cimport Marks
from colonysim.trace.block cimport Block
from colonysim.trace.writer cimport TraceWriter


@cython.final
cdef class Rows:
    cdef long long _episode
    cdef object _write, _kinds, _before
    cdef bint _decisions, _deposits
    cdef long long[::1] _holes, _numbers
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
    cpdef ended(
        self, int agent, str action, Py_ssize_t origin, Py_ssize_t target, int box, Py_ssize_t hole, str status,
        str reason, long long step, double began, Py_ssize_t now_at,
    )

    @cython.locals(block=Block, i=cython.Py_ssize_t)
    cpdef chose(
        self, int agent, Py_ssize_t node, bint explored, Py_ssize_t chosen, int[::1] targets, int[::1] boxes,
        double[::1] probabilities, Py_ssize_t count,
    )

    @cython.locals(block=Block, name=str, by_box=cython.bint, i=int, place="long long", key=cython.Py_ssize_t, value=double)
    cpdef marked(self, Marks field, int agent, int count)

    cdef _settle(self, str table, Block block)
