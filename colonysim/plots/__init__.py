"""Figures of runs, sweeps and trainings, drawn from their directories alone.

`draw` draws a run, `draw_results` a sweep or several runs, `draw_training` a training. matplotlib is imported when
something is drawn.
"""

from colonysim.plots.images import save
from colonysim.plots.of_results import DRAWN_MEASURES, RESULT_KINDS, draw_results
from colonysim.plots.of_run import FIELDS, KINDS, OF_AGENTS, PUSH_KINDS, draw, figures
from colonysim.plots.of_training import draw_training, is_training

__all__ = [
    "DRAWN_MEASURES", "FIELDS", "KINDS", "OF_AGENTS", "PUSH_KINDS", "RESULT_KINDS", "draw", "draw_results",
    "draw_training", "figures", "is_training", "save",
]  # fmt: skip
