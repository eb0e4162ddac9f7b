"""The skill of pushing a box: controls, executors, models. It uses the physics and knows no colonies."""

from colonysim.push.driving import drive_to
from colonysim.push.paths import Obstacles, Surroundings, everything_else
from colonysim.push.scripted import PushSettings, scripted_push
from colonysim.push.staging import Face, Leg, PushPlan, face_for, plan_push, stage
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
    "Face",
    "Kind",
    "Leg",
    "Log",
    "Manoeuvre",
    "ManoeuvreResult",
    "Obstacles",
    "PushPlan",
    "PushSettings",
    "PushTask",
    "Surroundings",
    "WheelSpeeds",
    "drive_to",
    "everything_else",
    "face_for",
    "ignore",
    "plan_push",
    "run_alone",
    "scripted_push",
    "stage",
]
