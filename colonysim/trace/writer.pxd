# The types of writer.py when it is compiled.
cimport cython


@cython.final
cdef class TraceWriter:
    cdef public object directory, manifest, results
    cdef dict _pending, _digests, _packed, _parts, _open
    cdef str _lost
    cdef readonly Py_ssize_t block_rows
    cdef Py_ssize_t _group_rows, _rows_per_part
    cdef double _flush_seconds, _begun, _flushed, _shared
    cdef object _tap
    cdef bint _done

    @cython.locals(now=double)
    cpdef write(self, table, row)
