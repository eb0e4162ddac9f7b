# The types of nodeworld.py when it is compiled.
cimport cython
from colonysim.world.state cimport World

@cython.locals(at=int, base=double, j=int, found=list)
cpdef list what_can_be_pushed(World world, int box, targets)
