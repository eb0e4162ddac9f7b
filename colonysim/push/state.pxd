# The types of state.py when it is compiled.
cimport cython
from colonysim.physics.shapes cimport wrap

cdef double _BUMPER, _QUARTER_TURN, _EIGHTH_TURN

cpdef double fold(double angle)

@cython.locals(
    x=double, y=double, z=double, yaw=double, goal_x=double, goal_y=double, c=double, s=double, line=double,
    bx=double, by=double, gx=double, gy=double, beyond=double, node=double, yaw_agent=double,
    box_x=double, box_y=double, box_z=double, box_roll=double, box_pitch=double, box_yaw=double,
)
cpdef observe(robot, box, task, double bumper=*)

@cython.locals(
    sr=double, cr=double, sp=double, cp=double, sy=double, cy=double, up_x=double, up_y=double,
)
cdef double _tilt(double roll, double pitch, double yaw, double line)

@cython.locals(
    bx=double, by=double, bz=double, pitch=double, yw=double, gx=double, gy=double, gz=double, ps=double,
    ux=double, uy=double, reach=double, far=double, safe_reach=double, safe_far=double, dx=double, dy=double,
    distance=double, cross_track=double,
)
cdef tuple _features(state)
