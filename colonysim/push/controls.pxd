# The types of controls.py when it is compiled.
cimport cython
from colonysim.physics.shapes cimport wrap

cdef double _NO_LINE, _QUARTER_TURN, _FASTEST

cpdef control_speeds(control, state)

@cython.locals(bearing=double, turn=double)
cpdef _rotate(double x, double y)

@cython.locals(bearing=double, left=double, right=double, fastest=double)
cpdef _travel(double x, double y, double gain=*)

@cython.locals(dx=double, dy=double, length=double, along=double, x=double, y=double)
cpdef _align(state)

cpdef _beside(state, double side)
