"""The colony on the terminal while it runs: the map in characters, and how far it has come."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from colonysim.arguments import real
from colonysim.characters import visible
from colonysim.cli.console import error_console
from colonysim.cli.summary import episode_line

if TYPE_CHECKING:
    from types import TracebackType

    from rich.console import Console
    from rich.text import Text

    from colonysim.scenario.scenario import Scenario
    from colonysim.trace.reader import Run
    from colonysim.trace.schema import Event

__all__ = ["Board", "Pace", "Watch"]

# Agents pink and boxes blue, as in the plots.
AGENT, BOX, GOAL, HOLE, QUIET = "bold #000000 on #CC79A7", "#FFFFFF on #0072B2", "bold #009E73", "reverse", "dim"
_FRAME = 0.1
"""Seconds of wall clock between two pictures."""
_LONGEST = 0.5
"""No single event is waited for longer, seconds."""


class Pace:
    """Slows a run down to be seen, where a whole episode would take but an instant; to be called with every event.

    Args:
        seconds: Simulated seconds that pass in a second; 0 for as many as may be.
    """

    def __init__(self, seconds: float) -> None:
        self._seconds = real("pace", seconds, 0.0, 1e9)
        self._time = 0.0

    def __call__(self, event: Event) -> None:
        """Waits until it is time for an event."""
        if self._seconds:
            time.sleep(min(max(event.time - self._time, 0.0) / self._seconds, _LONGEST))
        self._time = 0.0 if event.kind == "episode" else event.time


class Board:
    """Where everybody and everything is, as the events tell it; nodes by their numbers in the file."""

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        self._ids = scenario.topology.ids
        self.reset()

    def reset(self) -> None:
        """Back to the start of an episode."""
        self.time, self.step, self.said = 0.0, 0, ""
        self.agents = {agent: self._ids[node] for agent, node in enumerate(self._scenario.agents_at_start)}
        self.boxes = {box: self._ids[start.node] for box, start in enumerate(self._scenario.boxes_at_start)}
        self.goal = self._ids[self._scenario.goal]

    def take(self, event: Event) -> None:
        """Takes note of an event."""
        self.time = event.time
        if event.kind != "change":
            self.step = max(self.step, event.step)
        if event.kind == "goal":
            self.agents.pop(event.agent, None)
        elif event.kind == "start":
            self.agents[event.agent] = event.node
        elif event.kind == "change":
            self._change(event)
        if event.kind != "end":
            return
        self.agents[event.agent] = event.now_at
        what = f"agent {event.agent} {event.action} {event.node} → {event.target}"
        self.said = visible(what if event.status == "arrived" else f"{what}: {event.status} {event.reason}".rstrip())
        if event.action == "push" and event.status == "arrived":
            self.boxes[event.box] = event.target

    def _change(self, event: Event) -> None:
        if event.action == "add_box":
            self.boxes[event.box] = event.node
        elif event.action == "remove_box":
            self.boxes.pop(event.box, None)
        elif event.action == "move_goal":
            self.goal = event.node
        self.said = visible(f"the timeline: {event.action}")

    def draw(self, width: int, height: int) -> Text:
        """The map, at most so many characters wide and high; what stands on something hides it."""
        from rich.text import Text

        topology, ids = self._scenario.topology, self._ids
        west, south = min(topology.x), min(topology.y)
        # A character is about twice as high as it is wide; two columns hold a number of two digits.
        scale = min(
            (width - 2) / (max(topology.x) - west or 1.0), 2 * (height - 1) / (max(topology.y) - south or 1.0), 8.0
        )
        cells: dict[tuple[int, int], tuple[str, str]] = {}
        rows = round((max(topology.y) - south) * scale / 2)

        def put(node: int, sign: str, style: str) -> None:
            i = topology.index[node]
            row, column = rows - round((topology.y[i] - south) * scale / 2), round((topology.x[i] - west) * scale)
            cells[row, column] = sign, style

        for node in ids:
            put(node, "·", QUIET)
        for hole in self._scenario.holes:
            put(ids[hole.node], " ", HOLE)
        put(self.goal, "◆", GOAL)
        for box, node in self.boxes.items():
            put(node, str(box % 10), BOX)
        for agent, node in self.agents.items():
            put(node, str(agent % 10), AGENT)
        lines = []
        for row in range(rows + 1):
            line = Text()
            for column, (sign, style) in sorted((at[1], cell) for at, cell in cells.items() if at[0] == row):
                line.append(" " * (column - len(line)))
                line.append(sign, style)
            lines.append(line)
        return Text("\n").join(lines)


class Watch:
    """Draws a run while it happens; to be called with every event.

    Args:
        scenario: What runs.
        episodes: How many there will be.
        console: Where to draw; standard error by default.
    """

    def __init__(self, scenario: Scenario, episodes: int, console: Console | None = None) -> None:
        from rich.live import Live

        self._console = console or error_console()
        self._board = Board(scenario)
        self._agents, self._episodes = len(scenario.agents), episodes
        self._shown = 0.0
        self._live = Live(console=self._console, auto_refresh=False, transient=True)

    def __enter__(self) -> Watch:
        self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._live.stop()

    def __call__(self, event: Event, run: Run) -> None:
        """Takes an event; draws if the last picture is old enough."""
        self._board.take(event)
        now = time.monotonic()
        if event.kind == "episode" or now - self._shown >= _FRAME:
            self._shown = now
            self._live.update(self._picture(event.episode), refresh=True)
        if event.kind == "episode":
            self._console.print(visible(episode_line(run.episodes[-1])), markup=False)
            self._board.reset()

    def _picture(self, episode: int) -> Text:
        from rich.text import Text

        board, console = self._board, self._console
        there = self._agents - len(board.agents)
        status = (
            f"episode {episode} of {self._episodes} · {board.time:.1f} s · step {board.step} · "
            f"{there} of {self._agents} at the goal"
        )
        # The last lines must fit under the map, or the terminal would scroll.
        picture = board.draw(console.width, max(console.height - 5, 4))
        return Text("\n").join([picture, Text(""), Text(status, "bold"), Text(visible(board.said), QUIET)])
