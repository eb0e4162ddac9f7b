"""The pheromone fields, one file each. A new kind is a new file, or a third party's entry point `colonysim.fields`."""

from colonysim.pheromones.box import BoxWorth
from colonysim.pheromones.distance import Distance, extent
from colonysim.pheromones.exploration import Exploration
from colonysim.pheromones.field import Field, Visit, Write
from colonysim.pheromones.hole import HoleTrail
from colonysim.pheromones.signal import Signal
from colonysim.pheromones.spreading import NodeValues

__all__ = [
    "BoxWorth", "Distance", "Exploration", "Field", "HoleTrail", "NodeValues", "Signal", "Visit", "Write", "extent",
]  # fmt: skip
