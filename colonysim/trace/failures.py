"""Which pushes and travels of a run failed, where, when and why: the next weakness to mend."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

from colonysim.arguments import wholes
from colonysim.errors import TraceError
from colonysim.intervals import wilson
from colonysim.trace.groups import group_at

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable

    from colonysim.trace.reader import Run
    from colonysim.trace.schema import Event

__all__ = ["Attempts", "Grouping", "Tally", "attempts"]

Grouping: TypeAlias = Literal["reason", "edge", "agent", "group"]
ACTIONS = ("travel", "take", "push")
UNTOLD = "(none told)"
"""Stands for the reason where a backend gave none."""


@dataclass(frozen=True, slots=True)
class Tally:
    """Failures of one kind.

    Attributes:
        action: "travel", "take" or "push".
        group: The reason, the edge ("3-4"), the agent or its group that they have in common.
        reasons: How many there are for each reason, the most frequent first.
        attempts: Out of how many: by reason all that the run has of this action, otherwise those there.
        first: The first of them.
    """

    action: str
    group: str
    reasons: dict[str, int]
    attempts: int
    first: Event

    @property
    def count(self) -> int:
        """How many failed."""
        return sum(self.reasons.values())

    @property
    def share(self) -> float:
        """The share of the attempts that failed."""
        return self.count / self.attempts

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's 95 % interval of that share."""
        return wilson(self.count, self.attempts)


@dataclass(frozen=True, slots=True)
class Attempts:
    """All pushes and travels of a run that have ended.

    Attributes:
        ends: Their events, in order.
        episodes: The episodes they are from, those that are not complete included.
        terrain: Of single pushes: the terrain of each episode. They have no nodes; it takes the place of the edge.
        group_of: The name of each agent's group, if there are any.
    """

    ends: tuple[Event, ...]
    episodes: tuple[int, ...]
    terrain: dict[int, str]
    group_of: tuple[str, ...] = ()

    @property
    def counts(self) -> dict[str, int]:
        """How many there are of each action."""
        found = Counter(event.action for event in self.ends)
        return {action: found[action] for action in ACTIONS}

    @property
    def failures(self) -> tuple[Event, ...]:
        """Those that did not arrive, in order."""
        return tuple(event for event in self.ends if event.status != "arrived")

    def place(self, event: Event) -> str:
        """Where an attempt was made: "3-4", from node 3 to node 4; of a single push the terrain."""
        return self.terrain.get(event.episode) or f"{event.node}-{event.target}"

    def tally(self, by: Grouping = "reason") -> list[Tally]:
        """Counts failures by action and reason, edge, agent or group, the most frequent first."""
        tried = Counter((event.action, "" if by == "reason" else self._group(event, by)) for event in self.ends)
        groups: dict[tuple[str, str], list[Event]] = {}
        for event in self.failures:
            groups.setdefault((event.action, self._group(event, by)), []).append(event)
        tallies = [
            Tally(action, group, _reasons(events), tried[action, "" if by == "reason" else group], events[0])
            for (action, group), events in groups.items()
        ]
        return sorted(tallies, key=lambda tally: -tally.count)

    def _group(self, event: Event, by: Grouping) -> str:
        if by == "edge":
            return self.place(event)
        if by == "group":
            return self.group_of[event.agent]
        return str(event.agent) if by == "agent" else event.reason or UNTOLD


def _reasons(events: Iterable[Event]) -> dict[str, int]:
    return dict(Counter(event.reason or UNTOLD for event in events).most_common())


def attempts(run: Run, episodes: Collection[int] | None = None) -> Attempts:
    """The pushes and travels of a run, of one that was interrupted or is under way too.

    What was under way when an episode ended is not among them.

    Args:
        run: The run.
        episodes: Only these.

    Raises:
        TraceError: The run has none of one of these episodes, a damaged part, or no trace.
    """
    if episodes is not None:
        episodes = wholes("episodes", episodes)
    begun: dict[int, None] = {}
    ends = []
    for event in run.events():
        begun[event.episode] = None
        if event.kind == "end" and (episodes is None or event.episode in episodes):
            ends.append(event)
    missing = sorted(set(episodes or ()) - set(begun))
    if missing:
        known = f"it has {min(begun)} to {max(begun)}" if begun else "it has none"
        raise TraceError(f"no episode {missing[0]} in this run; {known}")
    pushes = run.manifest.get("evaluation", {}).get("pushes", ())
    terrain = {push["episode"]: push["terrain"] for push in pushes}
    chosen = tuple(e for e in begun if episodes is None or e in episodes)
    return Attempts(tuple(ends), chosen, terrain, _groups(run))


def _groups(run: Run) -> tuple[str, ...]:
    if run.manifest.get("scenario") is None or not run.scenario.groups:
        return ()
    return tuple(group_at(run.scenario, agent) for agent in range(len(run.scenario.agents)))
