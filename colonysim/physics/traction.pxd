# The types of traction.py when it is compiled.
cimport cython

cdef double _SERVO, _UPRIGHT, _AT_REST, _ENDLESS, _DROWSY, _FALLING
cdef double _RADIUS, _HALF_TRACK, _FASTEST, _AHEAD_PER_WHEELS, _TURN_PER_WHEELS
cdef int _LOOK_TICKS


@cython.locals(left=double, right=double, fastest=double)
cpdef wheel_speeds(double forward, double turn)


@cython.locals(
    px=double, py=double, pz=double, x=double, y=double, z=double, w=double, upright=double, lean=double, tip=double,
)
cpdef origin_pose(position, rotation, double centre)


@cython.final
cdef class Traction:
    cdef object _engine, _frame, _pose
    cdef double _lift, _centre, _weight, _pull, _most, _twist, _most_torque, _fastest, _spread
    cdef tuple _force_at
    cdef bint _slow
    cdef int _countdown
    cdef readonly object body
    cdef readonly double left, right, upright, reach
    cdef readonly bint grounded, resting

    cpdef pose(self)

    @cython.locals(px=double, py=double, x=double, y=double, z=double, w=double)
    cpdef tuple course(self)

    @cython.locals(px=double, py=double, pz=double, x=double, y=double, z=double, w=double, height=double)
    cpdef double lowest(self)

    @cython.locals(turn=double, asked=double, most=double)
    cpdef ask(self, double left, double right)
    cpdef settle(self)
    cpdef look(self)

    @cython.locals(
        x=double, y=double, z=double, w=double, vx=double, vy=double, vz=double, wx=double, wy=double, wz=double,
        r02=double, r12=double, r20=double, r21=double, r22=double, left=double, right=double,
        ahead=double, aside=double, turning=double, fx=double, fy=double, most=double, asked=double, torque=double,
    )
    cpdef apply(self)
