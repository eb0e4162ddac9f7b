# The types of sight.py when it is compiled.
cimport cython
from colonysim.policies.view cimport FieldWindow, LocalView

cdef int SELF, NEIGHBOUR, BOX, HOLE
cdef double UNKNOWN


@cython.final
cdef class Sight:
    cdef LocalView _view
    cdef object _moves
    cdef readonly int node, box
    cdef readonly double chance
    cdef readonly tuple neighbours, holes
    cdef readonly list free, passable, tops, graspable, pushable
    cdef readonly bytearray mask

    @cython.locals(k=int, j=int, best=double, chance=double)
    cdef _look_at_pushes(self)
    @cython.locals(each=int, pushes=int, named=int, k=int, action=int, found=bytearray)
    cdef bytearray _mask(self)
    @cython.locals(group=int, which=int, pushes=int, k=int, node=int, box=int)
    cpdef intent(self, int action)
    @cython.locals(best=int, hole=int, least=double, most=double, away=double, worth=double, window=FieldWindow)
    cpdef int meant_for(self, int box) except? -1
    @cython.locals(at=int)
    cpdef write(self, parts, names, int boxes, int holes, float[::1] found)
    @cython.locals(x=double, y=double, goal_x=double, goal_y=double)
    cdef _of_self(self, float[::1] found, int at)
    @cython.locals(view=LocalView, asked=cython.bint, k=int, j=int, hole=int, x=double, y=double, other_x=double, other_y=double)
    cdef _of_neighbours(self, float[::1] found, int at)
    @cython.locals(j=int, key=int, window=FieldWindow)
    cdef _of_pheromones(self, list windows, tuple nodes, float[::1] found, int at)
    @cython.locals(worth=FieldWindow, box=int, node=int, k=int, x=double, y=double, box_x=double, box_y=double, dx=double, dy=double)
    cdef _of_boxes(self, int most, int most_holes, float[::1] found, int at)
    cdef double _chance(self, int box, int at) except? -2
    @cython.locals(hole=int, x=double, y=double, hole_x=double, hole_y=double)
    cdef _of_holes(self, float[::1] found, int at)
