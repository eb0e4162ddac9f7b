"""The images of a film: an episode's time spread over its frames, with a caption beside the scene."""

from __future__ import annotations

from bisect import bisect_right
from operator import attrgetter
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from colonysim.plots.paper import BOX, GOAL, INK, QUIET, named_in
from colonysim.trace.replay import change_in_words, places, stops
from colonysim.video.motion import by_events, by_poses, coming_and_leaving
from colonysim.video.scene import Scene
from colonysim.view.reading import kept_columns

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from colonysim.trace.reader import Run
    from colonysim.trace.schema import EpisodeResult, Event

__all__ = ["Film"]

_TALL = 3.6
"""Height of the paper, inches: letters and lines grow with the image."""
_MAP = 0.75
"""Share of the width that the scene takes."""
_LETTERS = 22
"""So many letters of a change's words go into a line."""
_REST = 1 / 16
"""Share of the film that shows the end, standing still."""


class Film:
    """The images of an episode, drawn when they are asked for.

    Example:
        ```python
        film = Film(run, run.episodes[-1], frames=300, fps=15, size=(960, 720))
        image = film[150]  # height x width x 3, 8 bits each
        ```

    Attributes:
        fps: Frames a second.
        size: Width and height, pixels.
    """

    def __init__(self, run: Run, result: EpisodeResult, frames: int, fps: int, size: tuple[int, int]) -> None:
        self.fps, self.size = fps, size
        moving = max(1, round(frames * (1 - _REST)) - 1)
        self._times = np.minimum(np.arange(frames) / moving, 1.0) * result.sim_seconds
        bodies = len(kept_columns(run, "poses", [result.episode])) > 0
        self._motion = (by_poses if bodies else by_events)(run, result.episode, self._times)
        self._came, self._left = coming_and_leaving(run, result.episode)
        dpi = size[1] / _TALL
        self._figure = Figure(figsize=(size[0] / dpi, _TALL), dpi=dpi, facecolor="white")
        self._canvas = _canvas(self._figure)
        scene_axes = self._figure.add_axes((0.0, 0.0, _MAP, 1.0))
        events = list(run.events(result.episode))
        self._scene = Scene(scene_axes, run.scenario, self._motion, bodies, places(run.scenario, events))
        self._stops = stops(events)
        side = self._figure.add_axes((_MAP, 0.0, 1 - _MAP, 1.0))
        pace = result.sim_seconds / moving * fps
        self._caption = _Caption(side, run, result, pace, [event for event in events if event.kind == "change"])
        self._canvas.draw()
        self._ground = self._canvas.copy_from_bbox(self._figure.bbox)
        self._parts: list[tuple[Axes, Artist]] = [(scene_axes, artist) for artist in self._scene.moving]
        self._parts += [(side, artist) for artist in self._caption.moving]

    def __len__(self) -> int:
        return len(self._times)

    def __getitem__(self, frame: int) -> NDArray[np.uint8]:
        time = float(self._times[frame])
        stopped = np.zeros(len(self._came), dtype=bool)
        stopped[[agent for agent, since, until in self._stops if since <= time < until]] = True
        self._scene.show(frame, time, (self._came <= time) & (time < self._left), stopped)
        self._caption.show(time, int((self._left <= time).sum()), self._scene.filled(frame))
        self._canvas.restore_region(self._ground)
        for axes, artist in self._parts:
            axes.draw_artist(artist)
        return np.ascontiguousarray(np.asarray(self._canvas.buffer_rgba())[..., :3])


def _canvas(figure: Figure) -> Any:
    # matplotlib's own types leave out what a canvas can do.
    return FigureCanvasAgg(figure)


class _Caption:
    """What is shown beside the scene."""

    def __init__(self, axes: Axes, run: Run, result: EpisodeResult, pace: float, changes: Sequence[Event]) -> None:
        axes.set(xlim=(0, 1), ylim=(0, 1))
        axes.axis("off")
        self._agents, self._holes = len(run.scenario.agents), len(run.scenario.holes)
        self._whole, self._changes = result.sim_seconds, changes
        name, backend, policy = (named_in(run, field) for field in ("name", "backend", "policy"))
        # A name with two dollar signs is a name, no formula.
        axes.text(0.06, 0.94, name, fontsize=13, weight="bold", color=INK, va="top", parse_math=False)
        quiet = f"{backend}\n{policy}\nepisode {result.episode}"
        axes.text(0.06, 0.86, quiet, fontsize=8, color=INK, va="top", linespacing=1.5, parse_math=False)
        axes.text(0.06, 0.03, run.shortfall, fontsize=6, color="#666666", va="bottom")
        for y, label in ((0.60, f"time (×{pace:.2g})"), (0.42, "at the goal"), (0.24, "holes filled")):
            axes.text(0.06, y, label, fontsize=8, color="#666666", va="bottom")
        self._bars = []
        for y, color in ((0.495, INK), (0.315, GOAL), (0.135, BOX)):
            axes.add_patch(Rectangle((0.06, y), 0.84, 0.012, color=QUIET, linewidth=0))
            bar = Rectangle((0.06, y), 0.0, 0.012, color=color, linewidth=0, animated=True)
            axes.add_patch(bar)
            self._bars.append(bar)
        self._texts = [
            axes.text(0.06, y, "", fontsize=12, weight="bold", color=INK, va="top", animated=True)
            for y in (0.59, 0.41, 0.23)
        ]
        self._last = axes.text(0.06, 0.695, "", fontsize=6, color="#666666", va="center", animated=True)
        self.moving: list[Artist] = [*self._bars, *self._texts, self._last]

    def show(self, time: float, home: int, filled: int) -> None:
        texts = (f"{time:.0f} s", f"{home} of {self._agents}", f"{filled} of {self._holes}")
        shares = (time / (self._whole or 1.0), home / (self._agents or 1), filled / (self._holes or 1))
        for text, words, bar, share in zip(self._texts, texts, self._bars, shares, strict=True):
            text.set_text(words)
            bar.set_width(0.84 * share)
        done = bisect_right(self._changes, time, key=attrgetter("time"))
        self._last.set_text(fill(change_in_words(self._changes[done - 1]), _LETTERS) if done else "")
