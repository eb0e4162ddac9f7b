"""The rigid-body scene: ground with pits and ramps, boxes, wheeled robots.

It knows neither colonies nor learning. Importing this package needs no physics engine; creating a
[`Scene`][colonysim.physics.scene.Scene] does, and says how to get one when it is missing.
"""

from colonysim.physics.bullet import window_trouble
from colonysim.physics.engine import (
    ENGINES,
    Engine,
    EngineFacts,
    EngineName,
    MissingEngineError,
    default_engine,
    engine_facts,
    engine_trouble,
    engine_version,
    make_engine,
)
from colonysim.physics.pits import Pit
from colonysim.physics.robot import (
    BUMPER,
    HALF_WIDTH,
    MAX_WHEEL_SPEED,
    TRACK,
    WHEEL_RADIUS,
    WheelSpeeds,
    wheel_speeds,
)
from colonysim.physics.scene import TICK_SECONDS, Scene, ticks_to_close
from colonysim.physics.shapes import BoxSpec, Pose, RobotSpec, wrap
from colonysim.physics.terrain import Ground, Ramp, Terrain

__all__ = [
    "BUMPER",
    "ENGINES",
    "HALF_WIDTH",
    "MAX_WHEEL_SPEED",
    "TICK_SECONDS",
    "TRACK",
    "WHEEL_RADIUS",
    "BoxSpec",
    "Engine",
    "EngineFacts",
    "EngineName",
    "Ground",
    "MissingEngineError",
    "Pit",
    "Pose",
    "Ramp",
    "RobotSpec",
    "Scene",
    "Terrain",
    "WheelSpeeds",
    "default_engine",
    "engine_facts",
    "engine_trouble",
    "engine_version",
    "make_engine",
    "ticks_to_close",
    "wheel_speeds",
    "window_trouble",
    "wrap",
]
