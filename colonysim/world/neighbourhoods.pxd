# The types of neighbourhoods.py when it is compiled.
cimport cython


@cython.final
cdef class Neighbourhoods:
    cdef readonly double[::1] x, y
    cdef readonly double limit, radius
    cdef readonly int most
    cdef readonly bint kept
    cdef readonly int[::1] first, nodes
    cdef int[::1] _cell, _members_first, _members, _beside_first, _beside

    @cython.locals(
        node=int, cell=int, cells=dict, sizes="int[::1]", filled="int[::1]", column="long long", row="long long", i="long long",
        j="long long", count=int, most=int,
    )
    cdef int _fill_cells(self, int size, double side) except -1
    @cython.locals(node=int, count=int, total="long long")
    cdef _gather_all(self, int size, long long room)
    @cython.locals(x=double, y=double, dx=double, dy=double, limit=double, count=int, cell=int, k=int, other=int, m=int, j=int)
    cpdef int gather(self, int node, int[::1] found)
    @cython.locals(dx=double, dy=double)
    cpdef bint both(self, int i, int j)
