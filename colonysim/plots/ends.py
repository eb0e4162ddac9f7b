"""Where the boxes and the goal are at the end of an episode."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from colonysim.trace.replay import follow, with_boxes

if TYPE_CHECKING:
    from colonysim.trace.reader import Run

__all__ = ["EpisodeEnd", "EpisodeEnds"]


class EpisodeEnd(NamedTuple):
    """Node numbers of the boxes that are there at an episode's end, and of the goal."""

    boxes: dict[int, int]
    goal: int


class EpisodeEnds:
    """How a run's episodes ended: each is followed once, for however many figures."""

    def __init__(self, run: Run) -> None:
        self._run = run
        self._found: dict[int, EpisodeEnd] = {}

    def of(self, episode: int) -> EpisodeEnd:
        """That of an episode."""
        if episode not in self._found:
            scenario = self._run.scenario
            ways = follow(scenario, self._run.events(episode))
            goal = with_boxes(scenario, {}, ways.changed).goal if ways.changed else scenario.goal
            self._found[episode] = EpisodeEnd(ways.boxes_at_end(), scenario.topology.ids[goal])
        return self._found[episode]
