"""What of a run is kept: what was asked for, else what the size of its world allows."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, get_args

from colonysim.arguments import shown
from colonysim.errors import ColonysimError
from colonysim.suggest import nearest
from colonysim.trace.schema import Table

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from colonysim.scenario.scenario import Scenario

__all__ = ["LAST_FRAMES", "WORDS", "Kept", "asked_for", "by_size", "dropped_in", "left_out"]

ALWAYS: tuple[Table, ...] = ("events", "episodes", "measurements")
"""Tables that every run has."""
LAST_FRAMES = "last-frames"
"""Asks for the key frames of the last episode only."""
_UNASKED = ("episodes", "measurements")
WORDS = (*(table for table in get_args(Table) if table not in _UNASKED), LAST_FRAMES)
"""What may be asked for."""
MOST_ROWS: dict[str, float] = {"decisions": 20e6, "deposits": 20e6, "frames": 5e6}
"""Rows of a table, as they are expected, from which on it is left out or thinned unless it is asked for."""
MOST_LAST_FRAMES = 50e6
"""The same of the key frames of one episode."""
_HOLES_KNOWN = 4
"""A deposit tells of one hole in so many."""
_VISITS = 10
"""So many steps for each node of the place, agents come to an end if `max_steps` lets them."""


@dataclass(frozen=True, slots=True)
class Kept:
    """The tables that a run keeps.

    Attributes:
        tables: Their names, in the order of `schema.TABLES`.
        last_frames: Whether "frames" has those of the last episode only.
        why: "asked for", or what is left out for the size of the world, or that everything is kept.
        thinned: Whether anything is left out for that.
    """

    tables: tuple[Table, ...]
    last_frames: bool = False
    why: str = "everything, by default"
    thinned: bool = False

    @property
    def dropped(self) -> tuple[Table, ...]:
        """The tables that are not kept."""
        return tuple(table for table in get_args(Table) if table not in self.tables)

    def without(self, table: Table) -> Kept:
        """The same without a table."""
        why = f"without {table}, as asked for" + (f"; {self.why}" if self.thinned else "")
        return replace(self, tables=tuple(each for each in self.tables if each != table), why=why)

    def document(self) -> dict[str, Any]:
        """What a manifest says of it below "recorded"."""
        frames = "none" if "frames" not in self.tables else "last" if self.last_frames else "all"
        return {"tables": list(self.tables), "frames": frames, "why": self.why}


def dropped_in(manifest: Mapping[str, Any]) -> tuple[Table, ...]:
    """The tables that a run does not keep, as its manifest says."""
    kept = manifest["recorded"]["tables"]
    return tuple(table for table in get_args(Table) if table not in kept)


def asked_for(words: str | Iterable[str]) -> Kept:
    """What was asked for; events, episodes and measurements are always kept.

    Args:
        words: Of `WORDS`; as one text, parted by commas.

    Raises:
        ColonysimError: One of them does not exist, or two of them contradict each other.

    Example:
        >>> asked_for("events,last-frames").tables
        ('events', 'frames', 'episodes', 'measurements')
    """
    try:
        asked = [*(words.split(",") if isinstance(words, str) else words)]
    except TypeError:
        raise ColonysimError(f"record: {shown(words)}, expected names such as events,decisions") from None
    asked = [word.strip() if isinstance(word, str) else word for word in asked]
    for word in asked:
        if word not in (*WORDS, *_UNASKED):
            raise ColonysimError(f"record: {shown(word)} is nothing that a run keeps; {nearest(str(word), WORDS)}")
    if {"frames", LAST_FRAMES} <= {*asked}:
        raise ColonysimError(f"record: frames are of every episode, {LAST_FRAMES} of the last; leave out one of them")
    last = LAST_FRAMES in asked
    wanted = {*asked, *ALWAYS, *(["frames"] if last else [])}
    return Kept(tuple(table for table in get_args(Table) if table in wanted), last, "asked for")


def by_size(scenario: Scenario, episodes: int) -> Kept:
    """What is kept if nobody asks: everything, as long as no table will be so large that it hinders more than it helps.

    Rows are reckoned before the run begins, and rather too many: a decision for every step of every agent, a deposit
    for each of the fields D and E and for every fourth hole with it (on a grid of 130 x 130 with 500 holes there were
    24 million where that gives 82), a key frame's value for every node and hole. Agents take `max_steps` steps, or ten
    times as many as there are nodes if that is less.

    Args:
        scenario: What will be run.
        episodes: How many.
    """
    holes, nodes = len(scenario.holes), len(scenario.topology)
    steps = len(scenario.agents) * min(scenario.max_steps, _VISITS * nodes) * episodes
    frame = nodes * (2 + holes) + len(scenario.boxes) * holes
    kept, notes = Kept(get_args(Table)), []
    for table, rows in (("decisions", steps), ("deposits", steps * (2 + holes / _HOLES_KNOWN))):
        if rows > MOST_ROWS[table]:
            kept = kept.without(table)  # type: ignore[arg-type]
            notes.append(f"{table} ({_count(rows)} rows expected) are left out")
    if frame > MOST_LAST_FRAMES:
        kept = kept.without("frames")
        notes.append(f"frames ({_count(frame)} rows an episode expected) are left out")
    elif frame * episodes > MOST_ROWS["frames"] and episodes > 1:
        kept = replace(kept, last_frames=True)
        notes.append(f"frames ({_count(frame * episodes)} rows expected) are kept of the last episode only")
    return replace(kept, why=f"by default, for its size: {' and '.join(notes)}", thinned=True) if notes else kept


def left_out(manifest: Mapping[str, Any], table: Table, episode: int | None = None) -> str:
    """Why a run has no rows of a table, of an episode if given: a message for whoever needs them; "" if it may have.

    Args:
        manifest: The run's.
        table: Name of the table.
        episode: Which episode.
    """
    told = manifest.get("recorded")
    if told is None:  # by a version that did not know of it
        dropped = manifest.get("options", {}).get("decisions") is False and table == "decisions"
        return "this run has no decisions: it was recorded with --no-decisions" if dropped else ""
    last_only = table == "frames" and told["frames"] == "last" and episode not in (None, manifest["episodes"])
    if table in told["tables"] and not last_only:
        return ""
    words = [LAST_FRAMES if name == "frames" and told["frames"] == "last" else name for name in told["tables"]]
    asked = ",".join(word for word in words if word not in _UNASKED)
    which = f"{table} of episode {episode}" if last_only else table
    why = "" if told["why"] == "asked for" else f" ({told['why']})"
    return f"this run has no {which}: it was recorded with --record {asked}{why}"


def _count(rows: float) -> str:
    return f"{rows / 1e6:.0f} million" if rows >= 1e6 else f"{rows:.0f}"
