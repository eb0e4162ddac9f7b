"""The MuJoCo engine. The only module that imports MuJoCo, and only when an engine is made."""

from __future__ import annotations

import importlib
import json
from typing import TYPE_CHECKING, Any

from colonysim.physics.engine import EngineFacts, MissingEngineError, engine_version
from colonysim.physics.shapes import quaternion

if TYPE_CHECKING:
    from collections.abc import Sequence

    from colonysim.physics.shapes import Quat, Slab, Vec3

_UPWARDS = 0.5
"""A contact carries a wheel when its normal points up by at least this much."""
_IMPRATIO = 10.0
"""How much stiffer friction is than normal contact: at 1, boxes slide away from the bumper that pushes them."""
_PARKED = 1000.0
"""Bodies taken out of the world rest this far below it and this far from each other, metres."""
_GRAVITY = 9.81
_NO_FORCE = (0.0,) * 6


class MujocoEngine:
    """One MuJoCo world without ground.

    MuJoCo compiles a model of all its bodies: it is compiled at the first call that needs it, and no body can be added
    after that. Every pair of geoms that may touch is declared with its own friction, since MuJoCo would take the larger
    of two coefficients where the seam asks for their product. Bodies never sleep: with MuJoCo's sleeping, a saved state
    would not be exact.

    Args:
        dt: Physics step in seconds.

    Raises:
        MissingEngineError: MuJoCo cannot be loaded.
    """

    def __init__(self, *, dt: float) -> None:
        try:
            self._mj = mj = importlib.import_module("mujoco")
        except ImportError as error:
            raise MissingEngineError(f"MuJoCo cannot be loaded: {error}") from error
        self._spec = spec = mj.MjSpec()
        spec.option.timestep = dt
        spec.option.gravity = (0.0, 0.0, -_GRAVITY)
        # The network that was trained on Bullet pushes as well with this cone, and half as well with the other.
        spec.option.cone = mj.mjtCone.mjCONE_ELLIPTIC
        spec.option.impratio = _IMPRATIO
        spec.option.solver = mj.mjtSolver.mjSOL_NEWTON
        self.facts = EngineFacts(
            "mujoco", engine_version("mujoco"),
            {"dt": dt, "cone": "elliptic", "impratio": _IMPRATIO, "solver": "Newton"}, True,
        )  # fmt: skip
        # Of each geom: the body it belongs to, its friction, and whether it is a wheel.
        self._geoms: list[tuple[int, float, bool]] = []
        self._fixed: set[int] = set()
        self._bodies = 0
        self._compiled = False

    def add_slab(self, slab: Slab, friction: float) -> int:
        """A body that never moves."""
        number = self._next_body()
        self._fixed.add(number)
        x, y, z, w = quaternion(slab.yaw, slab.slope)
        self._add_geom(self._spec.worldbody, number, friction, slab.half, pos=slab.centre, quat=(w, x, y, z))
        return number

    def add_box(self, half: Vec3, position: Vec3, rotation: Quat, mass: float, friction: float) -> int:
        """A free box."""
        number = self._next_body()
        self._add_geom(self._free_body(number, position, rotation), number, friction, half, mass=mass)
        return number

    def add_robot(
        self,
        chassis_half: Vec3,
        chassis_mass: float,
        bumper_friction: float,
        wheels: Sequence[Vec3],
        wheel_radius: float,
        wheel_mass: float,
        position: Vec3,
        rotation: Quat,
    ) -> int:
        """A chassis, and rigidly fixed to it a body of all wheel spheres, so that forces act at the chassis centre."""
        number = self._next_body()
        chassis = self._free_body(number, position, rotation)
        self._add_geom(chassis, number, bumper_friction, chassis_half, mass=chassis_mass)
        axle = chassis.add_body(pos=(0.0, 0.0, wheels[0][2]))
        sphere = self._mj.mjtGeom.mjGEOM_SPHERE
        for x, y, _ in wheels:
            size = (wheel_radius, 0.0, 0.0)
            self._add_geom(axle, number, 0.0, size, wheel=True, type=sphere, pos=(x, y, 0.0), mass=wheel_mass)
        return number

    def pose(self, body: int) -> tuple[Vec3, Quat]:
        """Position and rotation of a body's frame."""
        if not self._compiled:
            self._compile()
        x, y, z, qw, qx, qy, qz = self._places[body].tolist()
        return (x, y, z), (qx, qy, qz, qw)

    def velocity(self, body: int) -> tuple[Vec3, Vec3]:
        """Linear and angular velocity of a body's frame, in the world's axes."""
        if not self._compiled:
            self._compile()
        vx, vy, vz, a, b, c = self._speeds[body].tolist()
        # MuJoCo tells the angular velocity of a free body in the body's own axes.
        return (vx, vy, vz), self._turned(body, a, b, c)

    def push(self, body: int, force: Vec3, at: Vec3, torque: Vec3) -> None:
        """Act on a body during the next step only; everything in the body's own frame."""
        if not self._compiled:
            self._compile()
        (fx, fy, fz), (ax, ay, az), (tx, ty, tz) = force, at, torque
        moment = (tx + ay * fz - az * fy, ty + az * fx - ax * fz, tz + ax * fy - ay * fx)
        self._forces[body][:] = self._turned(body, fx, fy, fz) + self._turned(body, *moment)
        self._pushed.append(body)

    def stands(self, robot: int) -> bool:
        """Whether a wheel of the robot rested on something below it in the last step."""
        return robot in self._contacts()[0]

    def touching(self, one: int, other: int) -> bool:
        """Whether two bodies pressed against each other in the last step."""
        return (min(one, other), max(one, other)) in self._contacts()[1]

    def place(self, body: int, position: Vec3, rotation: Quat) -> None:
        """Put a body somewhere, at rest."""
        if not self._compiled:
            self._compile()
        x, y, z, w = rotation
        self._places[body][:] = (*position, w, x, y, z)
        self._speeds[body][:] = _NO_FORCE
        self._warm[body][:] = _NO_FORCE
        self._forces[body][:] = _NO_FORCE

    def wake(self, body: int) -> None:
        """Nothing: no body sleeps."""

    def remove(self, body: int) -> None:
        """Parks a body out of everybody's reach, its weight carried."""
        self.place(body, (_PARKED * (body + 1), 0.0, -_PARKED), (0.0, 0.0, 0.0, 1.0))
        weight = _GRAVITY * float(self._model.body_subtreemass[self._row[body]])
        # At its own centre of mass a robot would be carried level; a slow turn of what is out of the world is no harm.
        self._forces[body][:] = (0.0, 0.0, weight, 0.0, 0.0, 0.0)

    def step(self) -> None:
        """Advance by one physics step."""
        if not self._compiled:
            self._compile()
        self._advance(self._model, self._data)
        for body in self._pushed:
            self._forces[body][:] = _NO_FORCE
        self._pushed.clear()
        self._touch: tuple[set[int], set[tuple[int, int]]] | None = None

    def save(self) -> bytes:
        """The whole state between two steps: running on from it gives the same bits."""
        if not self._compiled:
            self._compile()
        state, kind = self._state()
        self._mj.mj_getState(self._model, self._data, state, kind)
        standing, pressed = self._contacts()
        # The contacts of the last step are asked for before the next, and are no part of MuJoCo's state.
        head = json.dumps({"engine": self.facts.name, "version": self.facts.version, "numbers": len(state),
                           "standing": sorted(standing), "pressed": sorted(pressed)})  # fmt: skip
        return head.encode() + b"\n" + state.astype("<f8").tobytes()

    def load(self, state: bytes) -> None:
        """Go on from a saved state of an engine with the same bodies.

        Raises:
            ValueError: It is no such state.
        """
        if not self._compiled:
            self._compile()
        numbers, kind = self._state()
        head, _, rest = state.partition(b"\n")
        try:
            said = json.loads(head)
            fits = (said["engine"], said["numbers"], len(rest)) == (self.facts.name, len(numbers), 8 * len(numbers))
            standing = {int(body) for body in said["standing"]}
            pressed = {(int(one), int(other)) for one, other in said["pressed"]}
        except (ValueError, KeyError, TypeError, UnicodeDecodeError) as error:
            raise ValueError("no saved state of a MuJoCo engine") from error
        if not fits:
            raise ValueError(f"a saved state of another scene: {said['numbers']} numbers, expected {len(numbers)}")
        numbers[:] = self._numpy.frombuffer(rest, dtype="<f8")
        self._mj.mj_setState(self._model, self._data, numbers, kind)
        self._pushed.clear()
        self._touch = standing, pressed

    def close(self) -> None:
        """Free the model."""
        self._compiled = True
        self._spec = self._model = self._data = None

    def _state(self) -> tuple[Any, int]:
        kind = int(self._mj.mjtState.mjSTATE_INTEGRATION)
        return self._numpy.empty(self._mj.mj_stateSize(self._model, kind)), kind

    def _next_body(self) -> int:
        if self._compiled:
            raise RuntimeError("MuJoCo's model is compiled: bodies can be added before the first step only")
        self._bodies += 1
        return self._bodies - 1

    def _free_body(self, number: int, position: Vec3, rotation: Quat) -> Any:
        x, y, z, w = rotation
        body = self._spec.worldbody.add_body(name=f"b{number}", pos=position, quat=(w, x, y, z))
        body.add_freejoint()
        return body

    def _add_geom(self, body: Any, number: int, friction: float, size: Vec3, *, wheel: bool = False, **given: Any) -> None:
        given.setdefault("type", self._mj.mjtGeom.mjGEOM_BOX)
        # What touches what is said pair by pair.
        body.add_geom(name=f"g{len(self._geoms)}", size=size, contype=0, conaffinity=0, **given)
        self._geoms.append((number, friction, wheel))

    def _compile(self) -> None:
        """Declares who may touch whom, builds the model and looks up where each body's numbers lie."""
        import numpy

        mj, spec = self._mj, self._spec
        self._numpy = numpy
        for i, (body, friction, _) in enumerate(self._geoms):
            for j in range(i + 1, len(self._geoms)):
                other, others_friction, _ = self._geoms[j]
                if body == other or (body in self._fixed and other in self._fixed):
                    continue
                both = friction * others_friction
                pair = spec.add_pair(geomname1=f"g{i}", geomname2=f"g{j}")
                if both > 0.0:
                    pair.condim = 3
                    pair.friction = (both, both, 0.0, 0.0, 0.0)
                else:
                    pair.condim = 1
        self._model = model = spec.compile()
        self._data = data = mj.MjData(model)
        # The compiler puts all geoms of the fixed world first.
        rows = {mj.mj_name2id(model, mj.mjtObj.mjOBJ_GEOM, f"g{i}"): geom for i, geom in enumerate(self._geoms)}
        self._geoms = [rows[row] for row in range(len(rows))]
        mj.mj_forward(model, data)
        self._advance = mj.mj_step
        self._compiled = True
        self._pushed: list[int] = []
        self._touch = None
        self._row: dict[int, int] = {}
        self._places: dict[int, Any] = {}
        self._speeds: dict[int, Any] = {}
        self._warm: dict[int, Any] = {}
        self._forces: dict[int, Any] = {}
        for number in set(range(self._bodies)) - self._fixed:
            row = self._row[number] = mj.mj_name2id(model, mj.mjtObj.mjOBJ_BODY, f"b{number}")
            joint = model.body_jntadr[row]
            at, dof = model.jnt_qposadr[joint], model.jnt_dofadr[joint]
            self._places[number] = data.qpos[at : at + 7]
            self._speeds[number] = data.qvel[dof : dof + 6]
            self._warm[number] = data.qacc_warmstart[dof : dof + 6]
            self._forces[number] = data.xfrc_applied[row]

    def _turned(self, body: int, a: float, b: float, c: float) -> Vec3:
        """A vector in a body's own axes, in the world's."""
        _, _, _, w, x, y, z = self._places[body].tolist()
        return (
            a * (1 - 2 * (y * y + z * z)) + b * 2 * (x * y - w * z) + c * 2 * (x * z + w * y),
            a * 2 * (x * y + w * z) + b * (1 - 2 * (x * x + z * z)) + c * 2 * (y * z - w * x),
            a * 2 * (x * z - w * y) + b * 2 * (y * z + w * x) + c * (1 - 2 * (x * x + y * y)),
        )

    def _contacts(self) -> tuple[set[int], set[tuple[int, int]]]:
        """Robots whose wheels rested on something in the last step, and pairs of bodies that pressed each other."""
        if not self._compiled:
            self._compile()
        if self._touch is None:
            contact, forces = self._data.contact, self._data.efc_force
            standing: set[int] = set()
            pressed: set[tuple[int, int]] = set()
            upwards, rows = contact.frame[:, 2].tolist(), contact.efc_address.tolist()
            for (i, j), up, row in zip(contact.geom.tolist(), upwards, rows, strict=True):
                (one, _, wheel), (other, _, others_wheel) = self._geoms[i], self._geoms[j]
                # A contact's normal points from its first geom to its second.
                if wheel and up < -_UPWARDS:
                    standing.add(one)
                elif others_wheel and up > _UPWARDS:
                    standing.add(other)
                if row >= 0 and forces[row] > 0.0:
                    pressed.add((min(one, other), max(one, other)))
            self._touch = standing, pressed
        return self._touch

