"""The PyBullet engine. The only module that imports PyBullet, and only when an engine is made."""

import importlib
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from colonysim.physics.engine import GRAVITY, UPWARDS, EngineFacts, MissingEngineError, engine_trouble, engine_version
from colonysim.physics.shapes import Quat, Slab, Vec3, quaternion

_WHEEL_LINK = 0
_ITERATIONS = 50
"""Solver iterations of a step."""
_SLEEP_THRESHOLD = 2e-4
"""Sum of squared speeds below which a body tires; the engine's default would stop a robot at .2 m/s."""
_PATIENCE = 60.0
"""Seconds of wall clock within which a window has opened."""


def display_trouble() -> str:
    """What keeps the engine from opening its window, in words; "" if nothing does.

    Without a display the engine ends the whole process, so another one tries: it shows a window for a moment.
    """
    trouble = engine_trouble("bullet")
    if trouble:
        return trouble
    opens = "import pybullet, sys; sys.exit(pybullet.connect(pybullet.GUI) < 0)"
    try:
        tried = subprocess.run(
            [sys.executable, "-c", opens], stdin=subprocess.DEVNULL, capture_output=True, timeout=_PATIENCE, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return str(error)
    said = tried.stderr.decode(errors="replace").split("\n")
    return "" if tried.returncode == 0 else next((line.strip() for line in reversed(said) if line.strip()), "no reason")


class BulletEngine:
    """One PyBullet world without ground.

    Args:
        dt: Physics step in seconds.
        gui: Show a window instead of running headless.

    Raises:
        MissingEngineError: PyBullet cannot be loaded.
    """

    def __init__(self, *, dt: float, gui: bool = False) -> None:
        try:
            self._p = p = importlib.import_module("pybullet")
        except ImportError as error:
            raise MissingEngineError(f"PyBullet cannot be loaded: {error}") from error
        self._client: int = p.connect(p.GUI if gui else p.DIRECT)
        if self._client < 0:
            raise RuntimeError("PyBullet gave no connection (with gui=True: is there a display?)")
        # Called for every robot in every step: looked up once.
        self._get_pose, self._get_velocity, self._step = (
            p.getBasePositionAndOrientation, p.getBaseVelocity, p.stepSimulation,
        )  # fmt: skip
        self._force, self._torque, self._own_frame = p.applyExternalForce, p.applyExternalTorque, p.LINK_FRAME
        p.resetSimulation(physicsClientId=self._client)
        p.setGravity(0.0, 0.0, -GRAVITY, physicsClientId=self._client)
        p.setPhysicsEngineParameter(
            fixedTimeStep=dt,
            numSubSteps=0,
            numSolverIterations=_ITERATIONS,
            deterministicOverlappingPairs=1,
            physicsClientId=self._client,
        )
        settings = {"dt": dt, "iterations": _ITERATIONS, "sleep_threshold": _SLEEP_THRESHOLD}
        # A saved state lacks the contact caches: a box that was being pushed is a centimetre off after 2.5 s.
        self.facts = EngineFacts("bullet", engine_version("bullet"), settings, False)

    def add_slab(self, slab: Slab, friction: float) -> int:
        """A body that never moves."""
        return self._create_box(slab.half, slab.centre, quaternion(slab.yaw, slab.slope), 0.0, friction)

    def add_box(self, half: Vec3, position: Vec3, rotation: Quat, mass: float, friction: float) -> int:
        """A free box; it may fall asleep."""
        body = self._create_box(half, position, rotation, mass, friction)
        self._let_sleep(body)
        return body

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
        """A chassis with one rigidly fixed link that holds all wheel spheres."""
        p, client = self._p, self._client
        chassis = p.createCollisionShape(p.GEOM_BOX, halfExtents=chassis_half, physicsClientId=client)
        axle_height = wheels[0][2]
        spheres = p.createCollisionShapeArray(
            shapeTypes=[p.GEOM_SPHERE] * len(wheels),
            radii=[wheel_radius] * len(wheels),
            collisionFramePositions=[[x, y, 0.0] for x, y, _ in wheels],
            physicsClientId=client,
        )
        body: int = p.createMultiBody(
            baseMass=chassis_mass,
            baseCollisionShapeIndex=chassis,
            basePosition=position,
            baseOrientation=rotation,
            linkMasses=[wheel_mass * len(wheels)],
            linkCollisionShapeIndices=[spheres],
            linkVisualShapeIndices=[-1],
            linkPositions=[[0.0, 0.0, axle_height]],
            linkOrientations=[[0.0, 0.0, 0.0, 1.0]],
            linkInertialFramePositions=[[0.0, 0.0, 0.0]],
            linkInertialFrameOrientations=[[0.0, 0.0, 0.0, 1.0]],
            linkParentIndices=[0],
            linkJointTypes=[p.JOINT_FIXED],
            linkJointAxis=[[0.0, 0.0, 1.0]],
            physicsClientId=client,
        )
        p.changeDynamics(body, -1, lateralFriction=bumper_friction, physicsClientId=client)
        p.changeDynamics(body, _WHEEL_LINK, lateralFriction=0.0, physicsClientId=client)
        self._let_sleep(body)
        return body

    def pose(self, body: int) -> tuple[Vec3, Quat]:
        """Position and rotation of a body's frame."""
        found: tuple[Vec3, Quat] = self._get_pose(body, self._client)
        return found

    def velocity(self, body: int) -> tuple[Vec3, Vec3]:
        """Linear and angular velocity of a body's frame, in the world's axes."""
        found: tuple[Vec3, Vec3] = self._get_velocity(body, self._client)
        return found

    def push(self, body: int, force: Vec3, at: Vec3, torque: Vec3) -> None:
        """Act on a body during the next step only; everything in the body's own frame."""
        self._force(body, -1, force, at, self._own_frame, self._client)
        self._torque(body, -1, torque, self._own_frame, self._client)

    def stands(self, robot: int) -> bool:
        """Whether a wheel of the robot rests on something below it."""
        contacts = self._p.getContactPoints(bodyA=robot, linkIndexA=_WHEEL_LINK, physicsClientId=self._client)
        return any(contact[7][2] > UPWARDS for contact in contacts)

    def touching(self, one: int, other: int) -> bool:
        """Whether two bodies pressed against each other in the last step."""
        contacts = self._p.getContactPoints(bodyA=one, bodyB=other, physicsClientId=self._client)
        return any(contact[9] > 0.0 for contact in contacts)

    def place(self, body: int, position: Vec3, rotation: Quat) -> None:
        """Put a body somewhere, at rest and awake."""
        p, client = self._p, self._client
        p.resetBasePositionAndOrientation(body, position, rotation, physicsClientId=client)
        p.resetBaseVelocity(body, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), physicsClientId=client)
        self.wake(body)

    def wake(self, body: int) -> None:
        """Wake a body: forces alone do not."""
        p = self._p
        p.changeDynamics(body, -1, activationState=p.ACTIVATION_STATE_WAKE_UP, physicsClientId=self._client)

    def remove(self, body: int) -> None:
        """Take a body out of the world."""
        self._p.removeBody(body, physicsClientId=self._client)

    def step(self) -> None:
        """Advance by one physics step."""
        self._step(self._client)

    def save(self) -> bytes:
        """Places and speeds of all bodies, but not all of the engine's memory: running on gives nearly the same."""
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "state.bullet")
            self._p.saveBullet(str(file), physicsClientId=self._client)
            return file.read_bytes()

    def load(self, state: bytes) -> None:
        """Go on from a saved state of an engine with the same bodies."""
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "state.bullet")
            file.write_bytes(state)
            try:
                self._p.restoreState(fileName=str(file), physicsClientId=self._client)
            except self._p.error as error:
                raise ValueError(f"no saved state of a Bullet engine with these bodies: {error}") from error

    def close(self) -> None:
        """Disconnect from PyBullet."""
        if self._client >= 0:
            self._p.disconnect(physicsClientId=self._client)
            self._client = -1

    def _create_box(self, half: Vec3, position: Vec3, rotation: Quat, mass: float, friction: float) -> int:
        p, client = self._p, self._client
        shape = p.createCollisionShape(p.GEOM_BOX, halfExtents=half, physicsClientId=client)
        body: int = p.createMultiBody(
            baseMass=mass,
            baseCollisionShapeIndex=shape,
            basePosition=position,
            baseOrientation=rotation,
            physicsClientId=client,
        )
        p.changeDynamics(body, -1, lateralFriction=friction, physicsClientId=client)
        return body

    def _let_sleep(self, body: int) -> None:
        p = self._p
        p.changeDynamics(
            body,
            -1,
            activationState=p.ACTIVATION_STATE_ENABLE_SLEEPING,
            sleepThreshold=_SLEEP_THRESHOLD,
            physicsClientId=self._client,
        )
