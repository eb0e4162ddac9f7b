"""Waiting and blocking: what the agents did over an episode's time, and how long they waited in each."""

from __future__ import annotations

from itertools import groupby
from operator import attrgetter
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.ticker import MaxNLocator

from colonysim.plots.paper import AGENT, BLOCKED, BOX, GOAL, QUIET, plain, title_of
from colonysim.plots.sheet import SCREEN, EmptyFigureError

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from colonysim.plots.sheet import Sheet
    from colonysim.scenario.groups import Group
    from colonysim.trace.reader import Run
    from colonysim.trace.schema import Event

__all__ = ["Span", "spans", "waiting_figure"]

_STATES = ("pushes", "travels", "waits for a taken node", "waits", "left at the goal", "stands still for good")
_COLOURS = (BOX, AGENT, "#E69F00", "#F0E442", GOAL, QUIET)
_WAITS = _STATES[2:4]


class Span(NamedTuple):
    """What an agent did from one moment to another, simulated seconds."""

    agent: int
    begin: float
    end: float
    state: str


def spans(events: Iterable[Event]) -> list[Span]:
    """What each agent did in one episode, one span after the other; between two actions nothing lasts but waiting."""
    found: list[Span] = []
    open_ones: dict[int, tuple[float, str]] = {}

    def close(agent: int, end: float) -> None:
        begin, state = open_ones.pop(agent, (end, ""))
        if end > begin:
            found.append(Span(agent, begin, end, state))

    for event in events:
        if event.kind == "end":
            close(event.agent, event.began)
            state = _STATES[0] if event.action == "push" else _STATES[1]
            found.append(Span(event.agent, event.began, event.time, state))
        elif event.kind == "wait":
            close(event.agent, event.time)
            open_ones[event.agent] = event.time, _WAITS[0] if event.target >= 0 else _WAITS[1]
        elif event.kind in ("goal", "spent", "lost"):
            close(event.agent, event.time)
            open_ones[event.agent] = event.time, _STATES[4] if event.kind == "goal" else _STATES[5]
        elif event.kind == "episode":
            for agent in list(open_ones):
                close(agent, event.time)
    return found


def waiting_figure(run: Run, episode: int, group: Group | None = None, sheet: Sheet = SCREEN) -> Figure:
    """Above, how many agents did what over the time of an episode; below, the share of waiting by episode, if any.

    Args:
        run: The run.
        episode: The episode above.
        group: The agents that count; None for all.
        sheet: What it is drawn on.

    Raises:
        EmptyFigureError: Nobody waited in any episode, and in this one nothing took any time.
    """
    agents = range(len(run.scenario.agents)) if group is None else group.agents
    numbers = [result.episode for result in run.episodes]
    shares = {state: np.zeros(len(numbers)) for state in _WAITS}
    shown: list[Event] = []
    for number, events in groupby(run.events(), key=attrgetter("episode")):
        own = [event for event in events if event.agent in agents or event.kind == "episode"]
        if number == episode:
            shown = own
        if number in numbers:
            for state, share in _shares(own).items():
                shares[state][numbers.index(number)] = share
    length = next(result.sim_seconds for result in run.episodes if result.episode == episode)
    times, counts = _counts(spans(shown), length)
    timed, waited = any(each.any() for each in counts.values()), any(share.any() for share in shares.values())
    if not timed and not waited:
        raise EmptyFigureError(f"in episode {episode} nothing took any time, and nobody waited in any")
    rows = timed + waited
    figure = sheet.figure(7.0, 0.6 + 2.6 * rows, title_of("Waiting and blocking", run, group))
    panels = [*figure.subplots(rows, 1, squeeze=False).flat]
    if timed:
        wrong = [event.time for event in shown if event.kind == "end" and event.status != "arrived"]
        _stack(panels[0], times, counts, wrong)
        plain(panels[0], "simulated time [s]", "agents", f"episode {episode}")
        panels[0].set(xlim=(0, max(length, 1e-9)), ylim=(0, len(agents)))
        panels[0].yaxis.set_major_locator(MaxNLocator(integer=True))
    if waited:
        below, bottom = panels[-1], np.zeros(len(numbers))
        for state in (state for state in _WAITS if shares[state].any()):
            below.bar(
                numbers, shares[state], bottom=bottom, color=_COLOURS[_STATES.index(state)], label=state, width=0.8
            )
            bottom += shares[state]
        plain(below, "episode", "time until the goal\nspent waiting [%]", "all episodes")
        below.set_xlim(numbers[0] - 0.6, numbers[-1] + 0.6)
        below.set_ylim(0, 1.08 * float(bottom.max()))
        below.xaxis.set_major_locator(MaxNLocator(integer=True))
    sheet.legend(figure, [handle for axes in panels for handle in axes.get_legend_handles_labels()[0]])
    return figure


def _stack(axes: Axes, times: np.ndarray, counts: dict[str, np.ndarray], wrong: Sequence[float]) -> None:
    kept = [i for i, state in enumerate(_STATES) if counts[state].any()]
    axes.stackplot(
        times, [counts[_STATES[i]] for i in kept], step="post", colors=[_COLOURS[i] for i in kept],
        labels=[_STATES[i] for i in kept], linewidth=0,
    )  # fmt: skip
    if wrong:
        axes.plot(
            wrong, [0] * len(wrong), "|", color=BLOCKED, markersize=9, label="did not arrive", clip_on=False
        )  # fmt: skip


def _counts(found: Sequence[Span], length: float) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """How many agents are in each state from each moment on at which that changes."""
    times = np.unique([0.0, length, *(span.begin for span in found), *(span.end for span in found)])
    counts = {state: np.zeros(len(times), dtype=np.int64) for state in _STATES}
    for span in found:
        counts[span.state][np.searchsorted(times, span.begin) : np.searchsorted(times, span.end)] += 1
    for each in counts.values():  # the last moment belongs to what was before it
        each[-1] = each[-2] if len(each) > 1 else 0
    return times, counts


def _shares(events: Iterable[Event]) -> dict[str, float]:
    """The waiting of all agents in an episode, per cent of their time under way."""
    found = [span for span in spans(events) if span.state in _STATES[:4]]
    whole = sum(span.end - span.begin for span in found)
    shares = dict.fromkeys(_WAITS, 0.0)
    for span in found:
        if span.state in shares:
            shares[span.state] += 100 * (span.end - span.begin) / whole
    return shares
