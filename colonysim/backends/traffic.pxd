# The types of traffic.py when it is compiled.
cimport cython
from colonysim.physics.scene cimport ticks_to_close

cdef double _TURNING, _BUMP, _BRAKING, _RADIUS, _FASTEST, _AHEAD, _ASIDE

@cython.locals(
    left=double, right=double, speed=double, x=double, y=double, yaw=double, reach=double, u=double, v=double,
    dx=double, dy=double, way=double, c=double, s=double,
)
cpdef bint closing_in(robot, speeds, others)

@cython.locals(x=double, y=double, nearest=double, u=double, v=double, away=double)
cpdef int ticks_until_close(robot, others)
