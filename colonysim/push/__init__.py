"""The skill of pushing a box: controls, executors, learning. It uses the physics and knows no colonies."""

from colonysim.push.task import (
    Chooser,
    Kind,
    Log,
    Manoeuvre,
    ManoeuvreResult,
    PushTask,
    WheelSpeeds,
    ignore,
    run_alone,
)

__all__ = [
    "Chooser",
    "Kind",
    "Log",
    "Manoeuvre",
    "ManoeuvreResult",
    "PushTask",
    "WheelSpeeds",
    "ignore",
    "run_alone",
]
