"""What the page is told of a run: its place, and what happened in it, episode by episode."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from colonysim.arguments import wholes
from colonysim.errors import TraceError
from colonysim.policies.parameters import shown
from colonysim.view.bodies import add_bodies, boxes_after
from colonysim.view.marks import Fields, add_marks
from colonysim.view.packing import Block
from colonysim.view.reading import Reading, no_pheromones

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Sequence

    from numpy.typing import NDArray

    from colonysim.scenario.changes import Change
    from colonysim.scenario.scenario import Scenario
    from colonysim.trace.reader import Run
    from colonysim.trace.schema import Table
    from colonysim.view.columns import Columns
    from colonysim.view.marks import Mark

__all__ = ["add_comings", "add_rows", "chosen_episodes", "gather", "introduce"]

_CHANCE = 10_000
"""Probabilities are kept as parts of ten thousand."""


def gather(
    run: Run,
    episodes: Sequence[int] | None = None,
    *,
    without: Collection[Table] = (),
    progress: Callable[[float], None] | None = None,
) -> Block:
    """Packs a run for the page.

    Args:
        run: The run.
        episodes: Which of its episodes; None for all that are complete.
        without: Tables that are left out. The pheromones need "deposits" and "frames"; they are left out together, and
            of a run that was not to keep what they need in any case.
        progress: Is told the share of the work that is done.

    Raises:
        TraceError: The run kept no trace, is one of single pushes, or lacks an episode.
    """
    scenario = run.scenario
    chosen = chosen_episodes(run, episodes)
    block = introduce(run)
    block.head["episodes"] = [list(each[:6]) for each in run.episodes if each.episode in set(chosen)]
    block.head["of"] = len(run.episodes)
    fields = Fields(run)
    first = run.episodes[0].episode
    if no_pheromones(run, chosen) or {"deposits", "frames"} & {*without}:
        without = {*without, "deposits", "frames"}
    reading = Reading(run, chosen, without, progress)
    before = [
        [] if episode == first or "frames" in without else fields.after(reading.frames(episode - 1))
        for episode in chosen
    ]
    add_rows(block, scenario, reading.columns, chosen, fields, before)
    return block


def introduce(run: Run) -> Block:
    """What the page needs to know before the first row: what was run, and the place."""
    scenario = run.scenario
    block = Block()
    block.head = {
        "name": scenario.name,
        "description": scenario.description,
        **{key: run.manifest.get(key) for key in ("variant", "backend", "policy", "mode", "status")},
        "seed": str(run.manifest["seed"]),  # a browser's numbers end at 2**53, seeds do not
        "hash": run.trace_sha256,
        "radius": scenario.detection_radius,
        **({"radii": [g.detection_radius for g in scenario.groups for _ in g.agents]} if scenario.groups else {}),
        "reach": scenario.reach,
        "maxSteps": scenario.max_steps,
        "chance": _CHANCE,
    }
    _add_place(block, scenario)
    add_comings(block, scenario, run.manifest.get("by_hand") or ())
    return block


def add_rows(
    block: Block,
    scenario: Scenario,
    table: Callable[[Table], Columns],
    episodes: Sequence[int],
    fields: Fields,
    before: Sequence[Sequence[Mark]],
) -> None:
    """Adds what happened.

    Args:
        block: What to add to.
        scenario: What was run.
        table: The rows of each table, of these episodes.
        episodes: Their numbers.
        fields: Of the policy.
        before: The pheromones as each of the episodes began.
    """
    nodes = _Nodes(scenario)
    events, poses = table("events"), table("poses")
    _add_events(block, events, nodes)
    block.ints("events.boxTo", nodes.index(boxes_after(scenario, events, poses)))
    _add_decisions(block, table("decisions"), nodes)
    add_marks(block, fields, before, table("deposits"), nodes.index)
    add_bodies(block, scenario, poses, episodes)


def chosen_episodes(run: Run, episodes: Sequence[int] | None) -> list[int]:
    """The episodes that are asked for, in order, each once; None for all that are complete.

    Raises:
        TraceError: The run lacks one of them, or no episode is complete.
    """
    complete = [result.episode for result in run.episodes]
    if not complete:
        raise TraceError(f"{run.path}: no episode of this run is complete, so there is nothing to show yet")
    chosen = complete if episodes is None else wholes("episodes", episodes)
    for number in chosen:
        if number not in complete:
            raise TraceError(f"no episode {number} in this run; it has {complete[0]} to {complete[-1]}")
    return sorted(set(chosen))


class _Nodes:
    """From the numbers in the scenario's file to indices; -1 stays -1."""

    def __init__(self, scenario: Scenario) -> None:
        ids = np.asarray(scenario.topology.ids)
        self._order = np.argsort(ids)
        self._sorted = ids[self._order]

    def index(self, numbers: NDArray[Any]) -> NDArray[np.int64]:
        numbers = np.asarray(numbers)
        if not len(numbers):
            return numbers.astype(np.int64)
        at = np.minimum(np.searchsorted(self._sorted, numbers), len(self._sorted) - 1)
        return np.where(self._sorted[at] == numbers, self._order[at], -1)


def _add_place(block: Block, scenario: Scenario) -> None:
    topology = scenario.topology
    block.ints("nodes.id", topology.ids, steps=True)
    for name in ("x", "y", "z"):
        block.reals(f"nodes.{name}", getattr(topology, name))
    begins, ends, rises = _edges(scenario)
    block.ints("edges.a", begins, steps=True)
    block.ints("edges.b", ends, steps=True)
    block.reals("edges.rise", rises)
    block.head["holes"] = [[hole.node, hole.floor, hole.rim] for hole in scenario.holes]
    block.ints("agents.node", scenario.agents)
    block.head["goal"] = scenario.goal


def _edges(scenario: Scenario) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Each edge once, from the smaller index to the larger: its two ends, and how much it rises."""
    ways = scenario.topology.edges
    begins = np.repeat(np.arange(len(scenario.topology)), np.diff(np.asarray(ways.first)))
    ends = np.asarray(ways.ends)
    once = begins < ends
    return begins[once], ends[once], np.asarray(ways.rises)[once]


def add_comings(block: Block, scenario: Scenario, by_hand: Sequence[int]) -> None:
    """Adds the boxes, and what the timeline brings: edges by index, how many of the last boxes and agents, heights.

    Args:
        block: What to add to.
        scenario: What is run.
        by_hand: Which changes of its timeline were made by hand.
    """
    block.ints("boxes.node", [box.node for box in scenario.boxes])
    block.reals("boxes.height", [box.height for box in scenario.boxes])
    brought = scenario.newcomers
    absent = brought.edges if brought else frozenset()
    edges = zip(*(column.tolist() for column in _edges(scenario)[:2]), strict=True) if absent else ()
    block.head["later"] = {
        "edges": [e for e, edge in enumerate(edges) if edge in absent],
        "boxes": len(brought.boxes) if brought else 0,
        "agents": len(brought.agents) if brought else 0,
        "surfaces": [change.z for change in scenario.changes],
        "wipes": [
            {"fields": change.fields, "nodes": change.nodes} if change.kind == "wipe" else None
            for change in scenario.changes
        ],
        "tunings": [_tuning(change) for change in scenario.changes],
        "byHand": list(by_hand),
    }


def _tuning(change: Change) -> str | None:
    """The parameters that a change sets, in words."""
    if change.parameters is None:
        return None
    words = ", ".join(f"{name} is {shown(value)}" for name, value in change.parameters.items())
    return f"{change.group}: {words}" if change.group else words


def _add_events(block: Block, events: Columns, nodes: _Nodes) -> None:
    block.ints("events.first", events.first)
    block.ints("events.time", events.milliseconds(), steps=True)
    # A difference of two times is small, the time itself is not.
    block.ints("events.took", events.milliseconds() - events.milliseconds("began"))
    for name in ("kind", "action", "status", "reason"):
        words, codes = events.words(name)
        block.head[f"words.{name}"] = words
        block.ints(f"events.{name}", codes)
    for name in ("node", "target", "hole", "now_at"):
        block.ints(f"events.{name}", nodes.index(events.column(name)))
    for name in ("agent", "box", "step"):
        block.ints(f"events.{name}", events.column(name))


def _add_decisions(block: Block, decisions: Columns, nodes: _Nodes) -> None:
    block.ints("decisions.first", decisions.first)
    block.ints("decisions.time", decisions.milliseconds(), steps=True)
    block.ints("decisions.agent", decisions.column("agent"))
    for name in ("node", "chosen", "targets"):
        block.ints(f"decisions.{name}", nodes.index(decisions.column(name)))
    block.ints("decisions.explored", decisions.column("explored"))
    block.ints("decisions.count", decisions.sizes("targets"))
    block.ints("decisions.boxes", decisions.column("boxes"))
    block.ints("decisions.chances", np.rint(decisions.column("probabilities") * _CHANCE))
