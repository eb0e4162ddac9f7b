"""The rigid-body scene: ground with pits and ramps, boxes, wheeled robots.

It knows neither colonies nor learning. Importing this package needs no physics engine; creating a
[`Scene`][colonysim.physics.scene.Scene] does, and says how to get one when it is missing.
"""

from colonysim.physics.bullet import display_trouble
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
    window_trouble,
)
from colonysim.physics.pits import Pit
from colonysim.physics.robot import HALF, STANDARD, Robot
from colonysim.physics.scene import TICK_SECONDS, Scene, ticks_to_close
from colonysim.physics.shapes import BoxSpec, Pose, RobotSpec, Slab, wrap
from colonysim.physics.terrain import Ground, Ramp, Terrain
from colonysim.physics.traction import WheelSpeeds, wheel_speeds

__all__ = [
    "ENGINES",
    "HALF",
    "STANDARD",
    "TICK_SECONDS",
    "BoxSpec",
    "Engine",
    "EngineFacts",
    "EngineName",
    "Ground",
    "MissingEngineError",
    "Pit",
    "Pose",
    "Ramp",
    "Robot",
    "RobotSpec",
    "Scene",
    "Slab",
    "Terrain",
    "WheelSpeeds",
    "default_engine",
    "display_trouble",
    "engine_facts",
    "engine_trouble",
    "engine_version",
    "make_engine",
    "ticks_to_close",
    "wheel_speeds",
    "window_trouble",
    "wrap",
]
