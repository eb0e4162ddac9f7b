# The types of paths.py when it is compiled.
cimport cython
from colonysim.push.footing cimport Footing

cdef double _CELL, _WINDOW, _ESCAPE
cdef int _SQUARE, _DISC


cdef class FreeSpace:
    cdef Footing _footing
    cdef double[::1] _squares, _discs
    cdef Py_ssize_t _square_count, _disc_count

    @cython.locals(
        squares=cython.double[::1], discs=cython.double[::1], k=cython.Py_ssize_t, i=cython.Py_ssize_t, least=double,
        dx=double, dy=double, c=double, s=double, half=double, clearance=double, u=double, v=double,
    )
    cpdef double slack(self, double x, double y)

    @cython.locals(
        x0=double, y0=double, x1=double, y1=double, part=double, share=double, k=cython.Py_ssize_t, parts=cython.Py_ssize_t,
    )
    cpdef bint clear(self, start, end, double least)


cdef class _Grid:
    cdef FreeSpace _space
    cdef double _start_x, _start_y, _at_start, xmin, ymin
    cdef readonly int columns, rows
    cdef readonly tuple first, last
    cdef dict _prices

    cdef tuple _cell(self, point)
    cdef tuple place(self, tuple cell)
    cdef price(self, tuple cell)

    @cython.locals(slack=double, dx=double, dy=double)
    cdef double _worked_out(self, double x, double y)


@cython.locals(grid=_Grid, queue=list, cost=dict, came=dict, done=set, here=tuple, there=tuple, dx=int, dy=int)
cdef _search(FreeSpace space, start, goal)
