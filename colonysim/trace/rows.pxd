# The types of rows.py when it is compiled.
cimport cython


cdef class Rows:
    cdef object _episode, _write
    cdef bint _decisions
    cdef tuple _holes, _names
    cdef public list events
    cdef public object now

    cpdef event(
        self, kind, agent=*, action=*, Py_ssize_t node=*, Py_ssize_t target=*, box=*, Py_ssize_t hole=*, status=*,
        reason=*, step=*, began=*, now_at=*,
    )
    cpdef decision(self, agent, Py_ssize_t node, explored, Py_ssize_t chosen, targets, boxes, probabilities)
    cpdef deposit(self, name, agent, Py_ssize_t node, double value)
