# cython: auto_pickle=False
"""A scene: terrain, boxes and robots in one engine, advanced by control ticks."""

import base64
import hashlib
import math
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Any, Self

from colonysim.physics.engine import STEP_SECONDS, Engine, EngineFacts, default_engine, make_engine
from colonysim.physics.robot import STANDARD, Robot
from colonysim.physics.shapes import BoxSpec, Pose, RobotSpec, euler, quaternion
from colonysim.physics.terrain import Pit, Terrain
from colonysim.physics.traction import UPRIGHT, Traction, build_robot, chassis_place

_STEPS_PER_TICK = 2
TICK_SECONDS = _STEPS_PER_TICK * STEP_SECONDS
"""Length of one control tick, in units of time: seconds with the standard robot."""
GROUND_FRICTION = 0.8
"""Of the ground under boxes; what the tyres have is the robot's grip."""
_FLIPPED_TICKS = 30
_SUNK = 0.08
_FALLEN = 0.3
_ENDLESS = math.inf
_make = tuple.__new__
_SEATED = 0.02
_CLOSER_IN_A_TICK = 2 * STANDARD.wheel_speed * STANDARD.wheel_radius * TICK_SECONDS
"""No robot is driven faster than the standard one can."""
_FOREVER = 1_000_000
_MOST_TICKS = 2**53


def ticks_to_close(gap: float) -> int:
    """For how many ticks two robots cannot come nearer to each other by such a distance; none if it is no number."""
    return int(min(gap / _CLOSER_IN_A_TICK, _FOREVER)) if gap > 0.0 else 0


def _check(terrain: Terrain, boxes: Sequence[BoxSpec]) -> None:
    """Refuses what engines answer in their own words, or not at all."""
    if not terrain.grounds:
        raise ValueError("the terrain has no ground")
    for i, box in enumerate(boxes):
        for name in ("length", "height", "mass"):
            if not 0.0 < (value := getattr(box, name)) < _ENDLESS:
                raise ValueError(f"box {i}: {name} {value}, expected a number above 0")
        if not 0.0 <= box.friction < _ENDLESS:
            raise ValueError(f"box {i}: friction {box.friction}, expected 0 or more")


def _each(robot: Robot | Sequence[Robot], count: int) -> tuple[Robot, ...]:
    """What robot each robot is, in its own units."""
    if isinstance(robot, Robot):
        return (robot.in_units(),) * count
    if len(robot) != count or len({each.scale for each in robot}) > 1:
        raise ValueError(f"expected {count} robots of one scale: a scene counts in units of it")
    return tuple(each.in_units() for each in robot)


class Scene:
    """Rigid bodies in one engine.

    A scene counts in units of its robots (`colonysim.physics.robot`): what it is given and what it answers are metres,
    kilograms and seconds with the standard robot, and with another one so many times `scale` metres, `mass_unit`
    kilograms and `time_unit` seconds. So its robots may differ in all but their scale.

    The same calls give the same poses bit for bit, also in another process with the same build of the same engine
    and processor family. Two engines give different poses.

    Args:
        terrain: The fixed ground.
        boxes: Boxes to create, in the order of their indices.
        robots: Robots to create, in the order of their indices.
        robot: What robot they are, in SI units: one for all, or one for each.
        gui: Show a window (Bullet only).
        engine: Name of the engine, or one that is empty and steps `STEP_SECONDS`; by default the first of "bullet" and
            "mujoco" that is installed.

    Attributes:
        terrain: The fixed ground.
        boxes: The boxes as they were created.
        models: What robot each of the robots is, in its own units.
        ticks: Control ticks since the scene was made.
        time: Simulated time since the scene was made.

    Raises:
        MissingEngineError: The engine is not installed.
        ValueError: There is no such engine, no ground, a box without size or mass, or robots of two scales.
    """

    tick_seconds = TICK_SECONDS

    def __init__(
        self,
        terrain: Terrain,
        boxes: Sequence[BoxSpec],
        robots: Sequence[RobotSpec],
        *,
        robot: Robot | Sequence[Robot] = STANDARD,
        gui: bool = False,
        engine: Engine | str | None = None,
    ) -> None:
        _check(terrain, boxes)
        self.terrain = terrain
        self.boxes = tuple(boxes)
        self._robots = tuple(robots)
        self.models = models = _each(robot, len(robots))
        self.ticks = 0
        self.time = 0.0
        if engine is None or isinstance(engine, str):
            engine = make_engine(engine or default_engine(), gui=gui)
        self._engine: Engine = engine
        for slab in terrain.slabs():
            self._engine.add_slab(slab, GROUND_FRICTION)
        self._boxes = [
            self._engine.add_box(
                (b.length / 2, b.length / 2, b.height / 2),
                (b.x, b.y, b.z + b.height / 2),
                quaternion(b.yaw),
                b.mass,
                b.friction,
            )
            for b in boxes
        ]
        self._tractions: list[Traction | None] = [
            Traction(self._engine, build_robot(self._engine, model, r), model)
            for r, model in zip(robots, models, strict=True)
        ]
        self._tilted = [0] * len(self._tractions)
        self._present = tuple(range(len(self._tractions)))
        self._bottom = min([g.z for g in terrain.grounds] + [pit.rim - pit.depth for pit in terrain.pits])
        # A robot whose lower end is no lower than this neither hangs in a pit nor has left the ground.
        self._safe = max([self._bottom - _FALLEN] + [pit.rim - _SUNK for pit in terrain.pits])
        # Poses, and what follows from them, are asked for many times between two changes of the scene.
        self._box_poses: dict[int, Pose] = {}
        self._seated: dict[tuple[int, Pit, float], bool] = {}
        self._open_pits: tuple[int, ...] | None = None
        self._standing: tuple[int, ...] | None = None

    @property
    def robot_count(self) -> int:
        """How many robots were created, removed ones included."""
        return len(self._tractions)

    def drive(self, robot: int, left: float, right: float) -> None:
        """Ask a robot for wheel speeds, kept until changed; a pair that the motors do not reach is scaled down.

        Args:
            robot: Index of the robot.
            left: Left wheel speed, rad/s, as of the standard robot's wheels.
            right: Right wheel speed, rad/s.

        Raises:
            ValueError: They are no finite numbers.
            LookupError: The robot has left the world.
        """
        self._traction(robot).ask(left, right)

    def tick(self) -> None:
        """Advance by one control tick: two physics steps, with the traction applied before each."""
        engine = self._engine
        tractions = [t for t in self._tractions if t is not None]
        for traction in tractions:
            traction.look()
        for _ in range(_STEPS_PER_TICK):
            for traction in tractions:
                traction.apply()
            engine.step()
        self.ticks += 1
        self.time = self.ticks * TICK_SECONDS
        self._forget()
        for i, traction in zip(self._present, tractions, strict=True):
            self._tilted[i] = 0 if traction.upright >= UPRIGHT else self._tilted[i] + 1

    def robot(self, i: int) -> Pose:
        """Pose of a robot; its origin lies on the ground between the wheels."""
        return self._traction(i).pose()

    def course(self, i: int) -> tuple[float, float, float]:
        """x, y and yaw of a robot: all of its pose that driving needs in every tick."""
        return self._traction(i).course()

    def box(self, i: int) -> Pose:
        """Pose of a box's centre; the yaw is raw, a square box looks the same every 90 degrees."""
        pose = self._box_poses.get(i)
        if pose is None:
            position, rotation = self._engine.pose(self._boxes[i])
            pose = self._box_poses[i] = _make(Pose, (*position, *euler(rotation)))
        return pose

    def has_robot(self, i: int) -> bool:
        """Whether a robot is still in the world."""
        return self._tractions[i] is not None

    def place_robot(self, i: int, x: float, y: float, z: float, yaw: float) -> None:
        """Put a robot somewhere, level, at rest, its wheels stopped; `z` is the ground under it."""
        traction = self._traction(i)
        self._engine.place(traction.body, *chassis_place(self.models[i], x, y, z, yaw))
        traction.settle()
        self._tilted[i] = 0
        self._forget()

    def place_box(self, i: int, x: float, y: float, z: float, yaw: float) -> None:
        """Put a box somewhere, level and at rest; `z` is the height of its underside."""
        self._engine.place(self._boxes[i], (x, y, z + self.boxes[i].height / 2), quaternion(yaw))
        self._forget()

    def remove_robot(self, i: int) -> None:
        """Take a robot's body out of the world; asking for its pose afterwards is an error."""
        self._engine.remove(self._traction(i).body)
        self._tractions[i] = None
        self._present = tuple(j for j in self._present if j != i)
        self._forget()

    def robot_fault(self, i: int) -> str | None:
        """What makes a robot unable to go on.

        Returns:
            `"nan"` when its pose is no number, `"flipped"` when it has been on its side or back for half a
            second, `"in_pit"` when its nose, middle or tail hangs in a pit, `"fallen"` when it left the
            ground, else None.
        """
        lowest, tilted = self._traction(i).lowest(), self._tilted[i]
        # Most robots stand upright on the highest ground.
        if self._safe <= lowest < _ENDLESS and tilted < _FLIPPED_TICKS:
            return None
        if not math.isfinite(lowest):
            return "nan"
        if tilted >= _FLIPPED_TICKS:
            return "flipped"
        x, y, z, _, pitch, yaw = self.robot(i)
        dip, c, s, nose = math.sin(pitch), math.cos(yaw), math.sin(yaw), self._traction(i).reach
        for pit in self.terrain.pits:
            for reach in (nose, 0.0, -nose):
                if z - reach * dip < pit.rim - _SUNK and pit.contains(x + reach * c, y + reach * s):
                    return "in_pit"
        return "fallen" if z < self._bottom - _FALLEN else None

    def robots_touch(self, i: int, j: int) -> bool:
        """Whether two robots pressed against each other in the last physics step."""
        return self._engine.touching(self._traction(i).body, self._traction(j).body)

    def box_fault(self, i: int) -> str | None:
        """`"nan"` when a box's pose is no number, `"fallen"` when it left the ground, else None."""
        x, y, z, roll, pitch, yaw = self.box(i)
        if not math.isfinite(x + y + z + roll + pitch + yaw):
            return "nan"
        return "fallen" if z < self._bottom - _FALLEN else None

    def box_seated(self, i: int, pit: Pit, tilt: float = 0.06) -> bool:
        """Whether a box lies level inside a pit, on the floor or on a stack of seated boxes.

        Args:
            i: Index of the box.
            pit: The pit.
            tilt: Largest roll or pitch, radians.
        """
        if not pit.contains(*self.box(i)[:2]):
            return False
        key = (i, pit, tilt)
        seated = self._seated.get(key)
        if seated is None:
            seated = self._seated[key] = self._is_seated(i, pit, tilt)
        return seated

    def _is_seated(self, i: int, pit: Pit, tilt: float) -> bool:
        pose, spec = self.box(i), self.boxes[i]
        if max(abs(pose.roll), abs(pose.pitch)) > tilt:
            return False
        floor = pit.rim - pit.depth
        underside = pose.z - spec.height / 2
        if underside > pit.rim - spec.height / 2:
            return False
        if abs(underside - floor) < _SEATED:
            return True
        return any(
            abs(self.box(j).z + other.height / 2 - underside) < _SEATED and self.box_seated(j, pit, tilt)
            for j, other in enumerate(self.boxes)
            if j != i and self.box(j).z < pose.z and pit.contains(*self.box(j)[:2])
        )

    def pit_filled(self, pit: Pit, step: float = 0.06) -> bool:
        """Whether boxes fill a pit to within `step` metres of its rim, so that a robot can cross it."""
        for i, spec in enumerate(self.boxes):
            pose = self.box(i)
            level = pit.rim - step < pose.z + spec.height / 2 and pose.z < pit.rim
            if level and self.box_seated(i, pit):
                return True
        return False

    def open_pits(self) -> tuple[int, ...]:
        """Indices of the pits that a robot cannot cross."""
        if self._open_pits is None:
            self._open_pits = tuple(i for i, pit in enumerate(self.terrain.pits) if not self.pit_filled(pit))
        return self._open_pits

    def standing_boxes(self) -> tuple[int, ...]:
        """Indices of the boxes that stand on the ground: not those whose centre is below the rim of a pit around it."""
        if self._standing is None:
            pits = self.terrain.pits
            places = [self.box(i) for i in range(len(self.boxes))]
            self._standing = tuple(
                i
                for i, box in enumerate(places)
                if not any(box.z < pit.rim and pit.contains(box.x, box.y) for pit in pits)
            )
        return self._standing

    def present_robots(self) -> tuple[int, ...]:
        """Indices of the robots that are still in the world."""
        return self._present

    @property
    def engine(self) -> EngineFacts:
        """Name, version and settings of the engine beneath."""
        return self._engine.facts

    def save(self) -> dict[str, Any]:
        """The state between two ticks, as plain data that JSON can hold.

        On an engine whose `exact_state` is true, a scene of the same bodies that has loaded it goes on with the same
        bits. On another one it does as long as nothing touches; bodies that push each other are some millimetres
        elsewhere after a few seconds.
        """
        return {
            "scene": self._digest(),
            "ticks": self.ticks,
            "engine": base64.b64encode(self._engine.save()).decode(),
            "tilted": list(self._tilted),
            "tractions": [None if traction is None else list(traction.state()) for traction in self._tractions],
        }

    def load(self, state: Mapping[str, Any]) -> None:
        """Goes on from a saved state of a scene with the same terrain, boxes and robots, perhaps of another process.

        Raises:
            ValueError: It is no such state: of other bodies, of another engine, or damaged.
        """
        try:
            of = str(state["scene"])
            ticks, tilted = int(state["ticks"]), [int(count) for count in state["tilted"]]
            driven = [None if each is None else Traction.read(each) for each in state["tractions"]]
            inner = base64.b64decode(state["engine"], validate=True)
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            raise ValueError("no saved state of a scene, or a damaged one") from error
        if not 0 <= ticks <= _MOST_TICKS:
            raise ValueError(f"a saved state after a number of ticks that cannot be, expected 0 to {_MOST_TICKS}")
        if of != self._digest() or not len(tilted) == len(driven) == len(self._tractions):
            raise ValueError("a saved state of another scene: other ground, boxes, robots or another engine")
        if any(now is None and then is not None for now, then in zip(self._tractions, driven, strict=True)):
            raise ValueError("a saved state in which a robot is present that has left this scene")
        for i, then in enumerate(driven):
            if then is None and self.has_robot(i):
                self.remove_robot(i)
        self._engine.load(inner)
        for traction, then in zip(self._tractions, driven, strict=True):
            if traction is not None and then is not None:
                traction.resume(then)
        self._tilted = tilted
        self.ticks, self.time = ticks, ticks * TICK_SECONDS
        self._forget()

    def _digest(self) -> str:
        """Hash of what the scene was built from and of the engine's name."""
        built = (self._engine.facts.name, self.terrain, self.boxes, self._robots, self.models)
        return hashlib.sha256(repr(built).encode()).hexdigest()

    def close(self) -> None:
        """Free the engine; calling it twice is allowed."""
        self._engine.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _forget(self) -> None:
        self._box_poses.clear()
        self._seated.clear()
        self._open_pits = self._standing = None

    def _traction(self, i: int) -> Traction:
        if i < 0:
            raise LookupError(f"no robot {i}")
        traction = self._tractions[i]
        if traction is None:
            raise LookupError(f"robot {i} has left the world")
        return traction
