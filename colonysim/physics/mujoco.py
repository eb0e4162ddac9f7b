# cython: auto_pickle=False
"""The MuJoCo engine. The only module that imports MuJoCo, and only when an engine is made."""

from __future__ import annotations

import importlib
import json
import math
import warnings
from typing import TYPE_CHECKING, Any, cast

from colonysim.physics.engine import GRAVITY, UPWARDS, EngineFacts, MissingEngineError, engine_version
from colonysim.physics.shapes import quaternion

if TYPE_CHECKING:
    from collections.abc import Sequence

    from colonysim.physics.shapes import Quat, Slab, Vec3

_IMPRATIO = 10.0
"""How much stiffer friction is than normal contact: at 1, boxes slide away from the bumper that pushes them."""
_PARKED = 1000.0
"""Bodies taken out of the world rest this far below it and this far from each other, metres."""


def _warn(message: str) -> None:
    warnings.warn(f"MuJoCo: {message}", RuntimeWarning, stacklevel=2)


class MujocoEngine:
    """One MuJoCo world without ground.

    MuJoCo compiles a model of all its bodies: it is compiled at the first call that needs it, and no body can be added
    after that. Every pair of boxes that may touch is declared with its own friction, since MuJoCo would take the larger
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
        if mj.get_mju_user_warning() is None:
            # Without one MuJoCo writes a file of its own into the current folder.
            mj.set_mju_user_warning(_warn)
        self._spec = spec = mj.MjSpec()
        spec.option.timestep = dt
        spec.option.gravity = (0.0, 0.0, -GRAVITY)
        # The network that was trained on Bullet pushes as well with this cone, and half as well with the other.
        spec.option.cone = mj.mjtCone.mjCONE_ELLIPTIC
        spec.option.impratio = _IMPRATIO
        spec.option.solver = mj.mjtSolver.mjSOL_NEWTON
        # Of a body that got out of hand the scene says so; MuJoCo would put all bodies back to where they began.
        spec.option.disableflags |= mj.mjtDisableBit.mjDSBL_AUTORESET
        self.facts = EngineFacts(
            "mujoco", engine_version("mujoco"),
            {"dt": dt, "cone": "elliptic", "impratio": _IMPRATIO, "solver": "Newton"}, True,
        )  # fmt: skip
        # Of each geom: the body it belongs to, its friction, and whether it is a wheel.
        self._geoms: list[tuple[int, float, bool]] = []
        self._fixed: set[int] = set()
        self._bodies = 0
        self._nowhere: dict[int, tuple[Vec3, Quat]] = {}
        self._compiled = False
        self._model: Any = None
        self._data: Any = None
        self._numpy: Any = None
        self._advance = mj.mj_step
        # Views of MuJoCo's arrays: reading and writing them is reading and writing the world.
        self._qpos: Any = None
        self._qvel: Any = None
        self._forces: Any = None
        # Where a body's place, its speeds and the forces on it begin in MuJoCo's arrays; -1 of what never moves.
        self._qpos_of: list[int] = []
        self._dof_of: list[int] = []
        self._row_of: list[int] = []
        self._pushed: list[int] = []
        self._touch: tuple[set[int], set[tuple[int, int]]] | None = None

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
        if self._nowhere and body in self._nowhere:
            return self._nowhere[body]
        at, qpos = self._place_of(body), self._qpos
        return (qpos[at], qpos[at + 1], qpos[at + 2]), (qpos[at + 4], qpos[at + 5], qpos[at + 6], qpos[at + 3])

    def velocity(self, body: int) -> tuple[Vec3, Vec3]:
        """Linear and angular velocity of a body's frame, in the world's axes."""
        if not self._compiled:
            self._compile()
        self._turn_as(body)
        dof, qvel = self._dof_of[body], self._qvel
        # MuJoCo tells the angular velocity of a free body in the body's own axes.
        return (qvel[dof], qvel[dof + 1], qvel[dof + 2]), self._turned(qvel[dof + 3], qvel[dof + 4], qvel[dof + 5])

    def push(self, body: int, force: Vec3, at: Vec3, torque: Vec3) -> None:
        """Act on a body during the next step only; everything in the body's own frame."""
        if not self._compiled:
            self._compile()
        (fx, fy, fz), (ax, ay, az), (tx, ty, tz) = force, at, torque
        self._turn_as(body)
        row, forces = 6 * self._row_of[body], self._forces
        forces[row], forces[row + 1], forces[row + 2] = self._turned(fx, fy, fz)
        forces[row + 3], forces[row + 4], forces[row + 5] = self._turned(
            tx + ay * fz - az * fy, ty + az * fx - ax * fz, tz + ax * fy - ay * fx
        )
        self._pushed.append(row)

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
        self._nowhere.pop(body, None)
        if not all(map(math.isfinite, (*position, *rotation))):
            # All bodies are solved for together: one that is nowhere would take the others along.
            self.remove(body)
            self._nowhere[body] = position, rotation
            return
        at = self._place_of(body)
        for i, number in enumerate((*position, w, x, y, z)):
            self._qpos[at + i] = number
        dof, row = self._dof_of[body], 6 * self._row_of[body]
        for i in range(6):
            self._qvel[dof + i] = self._data.qacc_warmstart[dof + i] = self._forces[row + i] = 0.0

    def wake(self, body: int) -> None:
        """Nothing: no body sleeps."""

    def remove(self, body: int) -> None:
        """Parks a body out of everybody's reach, its weight carried."""
        self.place(body, (_PARKED * (body + 1), 0.0, -_PARKED), (0.0, 0.0, 0.0, 1.0))
        row = self._row_of[body]
        self._forces[6 * row + 2] = GRAVITY * float(self._model.body_subtreemass[row])

    def step(self) -> None:
        """Advance by one physics step."""
        if not self._compiled:
            self._compile()
        self._advance(self._model, self._data)
        forces = self._forces
        for row in self._pushed:
            forces[row] = forces[row + 1] = forces[row + 2] = forces[row + 3] = forces[row + 4] = forces[row + 5] = 0.0
        self._pushed.clear()
        self._touch = None

    def save(self) -> bytes:
        """The whole state between two steps: running on from it gives the same bits."""
        if not self._compiled:
            self._compile()
        state, kind = self._state()
        self._mj.mj_getState(self._model, self._data, state, kind)
        standing, pressed = self._contacts()
        # The contacts of the last step are asked for before the next, and are no part of MuJoCo's state.
        head = json.dumps({"engine": self.facts.name, "version": self.facts.version, "numbers": len(state),
                           "standing": sorted(standing), "pressed": sorted(pressed),
                           "nowhere": [[body, *told] for body, told in self._nowhere.items()]})  # fmt: skip
        return head.encode() + b"\n" + bytes(state.astype("<f8"))

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
            made_by, count = (said["engine"], said["version"]), said["numbers"]
            standing = {int(body) for body in said["standing"]}
            pressed = {(int(one), int(other)) for one, other in said["pressed"]}
            nowhere = {int(body): (tuple(map(float, at)), tuple(map(float, turned)))
                       for body, at, turned in said["nowhere"]}  # fmt: skip
        except (ValueError, KeyError, TypeError, OverflowError, RecursionError) as error:
            raise ValueError("no saved state of a MuJoCo engine, or a damaged one") from error
        if made_by != (self.facts.name, self.facts.version):
            raise ValueError(f"a saved state of {made_by[1]!s:.80}, expected one of {self.facts.version}")
        if (count, len(rest)) != (len(numbers), 8 * len(numbers)):
            raise ValueError(f"a saved state of {count!s:.20} numbers in {len(rest)} bytes, expected {len(numbers)}")
        numbers[:] = self._numpy.frombuffer(rest, dtype="<f8")
        self._mj.mj_setState(self._model, self._data, numbers, kind)
        self._pushed.clear()
        self._touch = standing, pressed
        self._nowhere = cast("dict[int, tuple[Vec3, Quat]]", nowhere)

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

    def _add_geom(
        self, body: Any, number: int, friction: float, size: Vec3, *, wheel: bool = False, **given: Any
    ) -> None:
        given.setdefault("type", self._mj.mjtGeom.mjGEOM_BOX)
        if wheel:
            # It touches everything, always by its own rule: no friction.
            given |= {"contype": 1, "priority": 1, "condim": 1}
        else:
            given |= {"contype": 0}
        body.add_geom(name=f"g{len(self._geoms)}", size=size, conaffinity=1, **given)
        self._geoms.append((number, friction, wheel))

    def _compile(self) -> None:
        """Declares who may touch whom, builds the model and looks up where each body's numbers lie."""
        import numpy

        mj, spec = self._mj, self._spec
        self._numpy = numpy
        for numbers in (self._qpos_of, self._dof_of, self._row_of):
            numbers.extend([-1] * self._bodies)
        self._declare_pairs()
        self._model = model = spec.compile()
        self._data = data = mj.MjData(model)
        # The compiler puts all geoms of the fixed world first.
        rows = {mj.mj_name2id(model, mj.mjtObj.mjOBJ_GEOM, f"g{i}"): geom for i, geom in enumerate(self._geoms)}
        self._geoms = [rows[row] for row in range(len(rows))]
        mj.mj_forward(model, data)
        self._compiled = True
        self._qpos, self._qvel = memoryview(data.qpos), memoryview(data.qvel)
        self._forces = memoryview(data.xfrc_applied.reshape(-1))
        for number in set(range(self._bodies)) - self._fixed:
            row = self._row_of[number] = mj.mj_name2id(model, mj.mjtObj.mjOBJ_BODY, f"b{number}")
            joint = model.body_jntadr[row]
            self._qpos_of[number], self._dof_of[number] = model.jnt_qposadr[joint], model.jnt_dofadr[joint]

    def _declare_pairs(self) -> None:
        """Says the friction of each pair of geoms that may touch, but for wheels, which have none."""
        geoms = list(enumerate(self._geoms))
        for i, (body, friction, wheel) in geoms:
            for j, (other, others_friction, others_wheel) in geoms[i + 1 :]:
                if wheel or others_wheel or body == other or {body, other} <= self._fixed:
                    continue
                both = friction * others_friction
                self._spec.add_pair(
                    geomname1=f"g{i}", geomname2=f"g{j}", condim=3, friction=(both, both, 0.0, 0.0, 0.0)
                )

    def _place_of(self, body: int) -> int:
        at = self._qpos_of[body]
        if at < 0:
            raise LookupError(f"body {body} never moves: nothing is asked of it")
        return at

    def _turn_as(self, body: int) -> None:
        """Sets the axes of `_turned` to a body's own."""
        at, qpos = self._place_of(body) + 3, self._qpos
        w, x, y, z = qpos[at], qpos[at + 1], qpos[at + 2], qpos[at + 3]
        self._xx, self._xy, self._xz = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
        self._yx, self._yy, self._yz = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
        self._zx, self._zy, self._zz = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)

    def _turned(self, a: float, b: float, c: float) -> Vec3:
        """A vector in the axes of the body of the last `_turn_as`, in the world's."""
        return (
            a * self._xx + b * self._xy + c * self._xz,
            a * self._yx + b * self._yy + c * self._yz,
            a * self._zx + b * self._zy + c * self._zz,
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
                if wheel and up < -UPWARDS:
                    standing.add(one)
                elif others_wheel and up > UPWARDS:
                    standing.add(other)
                if row >= 0 and forces[row] > 0.0:
                    pressed.add((min(one, other), max(one, other)))
            self._touch = standing, pressed
        return self._touch

