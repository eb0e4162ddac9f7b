# The types of heap.py when it is compiled.
cimport cython

cdef double LAST


@cython.final
cdef class Heap:
    cdef readonly double key
    cdef readonly long long tie
    cdef readonly int count
    cdef double[::1] _keys
    cdef long long[::1] _ties, _items

    cpdef clear(self)
    @cython.locals(keys="double[::1]", ties="long long[::1]", items="long long[::1]", place=int, above=int)
    cpdef void put(self, double key, long long tie, long long item)
    @cython.locals(
        keys="double[::1]", ties="long long[::1]", items="long long[::1]", place=int, below=int, count=int, key=double,
        tie="long long", first="long long",
    )
    cpdef long long take(self)
    cdef _grow(self)
