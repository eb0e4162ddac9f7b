# The types of paths.py when it is compiled.
cimport cython
from colonysim.push.footing cimport Footing

cdef double _CELL, _WINDOW, _ESCAPE, _DIAGONAL
cdef int _SQUARE, _DISC


@cython.final
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


@cython.final
cdef class _Queue:
    cdef int[::1] _cells, _places
    cdef double[::1] _costs
    cdef int _count

    @cython.locals(cells="int[::1]", places="int[::1]", costs="double[::1]", place=int, above=int, other=int)
    cdef put(self, int cell, double cost)
    @cython.locals(cells="int[::1]", places="int[::1]", place=int, count=int, below=int, found=int, cell=int, other=int)
    cdef int pop(self)
    @cython.locals(a=double, b=double)
    cdef bint _before(self, int one, int other)


@cython.final
cdef class _Grid:
    cdef FreeSpace _space
    cdef double _start_x, _start_y, _at_start, _xmin, _ymin
    cdef int _columns, _rows, _first, _last
    cdef double[::1] _prices, _costs, _left
    cdef int[::1] _came
    cdef unsigned char[::1] _done

    @cython.locals(column=int, row=int)
    cdef int _cell(self, point)
    cdef _place(self, int cell)
    @cython.locals(price=double, column=int, row=int)
    cdef double _price(self, int cell)
    @cython.locals(slack=double, dx=double, dy=double)
    cdef double _worked_out(self, double x, double y)
    @cython.locals(left=double, rows=int, last=int, dx=int, dy=int)
    cdef double _ahead(self, int cell)

    @cython.locals(
        rows=int, columns=int, first=int, last=int, costs="double[::1]", came="int[::1]", done="unsigned char[::1]",
        queue=_Queue, here=int, there=int, spent=double, column=int, row=int, dx=int, dy=int, reached=double,
    )
    cpdef search(self)
