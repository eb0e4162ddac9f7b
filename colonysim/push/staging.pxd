# The types of staging.py when it is compiled.
cimport cython
from colonysim.physics.scene cimport Scene
from colonysim.physics.shapes cimport wrap
from colonysim.push.driving cimport Pilot
from colonysim.push.footing cimport Footing
from colonysim.push.paths cimport FreeSpace

cdef double _STEP, _NOWHERE


@cython.locals(
    x0=double, y0=double, x1=double, y1=double, parts=cython.Py_ssize_t, part=double, half=double, footing=Footing,
    c=double, s=double, before=double, before_left=double, before_right=double, k=cython.Py_ssize_t, share=double,
    x=double, y=double, here=double, left=double, right=double, least=double,
)
cdef double _corridor_slack(Scene scene, Py_ssize_t box, leg, FreeSpace space)

@cython.locals(x=double, y=double, yaw=double, dx=double, dy=double, away=double)
cpdef bint coarsely_staged(Pilot pilot, Py_ssize_t box, double heading, bint any_heading=*)
