"""How large a page becomes, by the rows of its episodes and before any of them is read; and what it leaves out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from colonysim.errors import TraceError
from colonysim.view.content import chosen_episodes
from colonysim.view.reading import no_pheromones

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from colonysim.trace.reader import Run
    from colonysim.trace.schema import Table

__all__ = ["Extent", "Room", "check_extent", "choose_extent"]

_ROW: dict[Table, float] = {"events": 10.0, "decisions": 12.0, "deposits": 5.0, "poses": 3.0, "frames": 1.5}
"""Bytes of a page that a row of each table takes, as measured on the maps that are shipped, rounded up."""
USUAL = 20e6
"""Bytes of a page that nobody asked for in particular; a browser opens it at once."""
MOST = 100e6
"""Bytes of the largest page; making it takes some 3 GB of memory."""
_MARKS: tuple[Table, ...] = ("deposits", "frames")
"""Pheromones: either without the other tells nothing."""

_Sizes = dict[int, dict["Table", float]]


@dataclass(frozen=True, slots=True)
class Room:
    """How large a page may be, and how its episodes are asked for where it is made.

    Attributes:
        usual: Bytes of a page that nobody asked for in particular.
        most: Bytes of the largest page.
        option: What chooses episodes, for messages.
        example: The same with a number in place of "{}".
    """

    usual: float
    most: float
    option: str = "--episodes"
    example: str = "--episodes {}"


@dataclass(frozen=True, slots=True)
class Extent:
    """What a page shows.

    Attributes:
        episodes: Which.
        without: Tables that it leaves out.
    """

    episodes: list[int]
    without: tuple[Table, ...] = ()


def choose_extent(
    run: Run, episodes: Sequence[int] | None, tell: Callable[[str], None], room: Room | None = None
) -> Extent:
    """What a page shows: the episodes that were asked for, else the last ones that fit and of a large one the motion.

    Args:
        run: The run.
        episodes: Which; None for as many as fit.
        tell: Is told what is left out and why, and how large the page will be if it is large.
        room: How large it may be; None for what a file may take.

    Raises:
        TraceError: The run lacks one of them, or they make a page that is too large.
    """
    room = room or Room(USUAL, MOST)
    chosen = chosen_episodes(run, episodes)
    rows = run.manifest["rows"]
    if run.status != "running" and sum(each * rows.get(table, 0) for table, each in _ROW.items()) <= room.usual:
        return Extent(chosen, _lacking(run, chosen, tell))
    sizes = _sizes(run)
    if episodes is None:
        chosen = _last_that_fit({number: sum(each.values()) for number, each in sizes.items()}, room.usual)
        first, last = chosen[0], chosen[-1]
        if first > min(sizes):
            shown = f"the last {len(chosen)}, {first} to {last}" if first != last else f"the last, {last}"
            whole = _size(sizes, sizes)
            tell(
                f"{run.path}: a page of all {len(sizes)} episodes would take about {_megabytes(whole)}; "
                f"it shows {shown}. Choose others with {room.option}."
            )
    without = _lacking(run, chosen, tell)
    if episodes is None:
        without = _light(run, sizes, chosen, without, tell, room)
    size = _check(run, sizes, chosen, "a page", room, without)
    if size > room.usual:
        tell(f"{run.path}: the page will take about {_megabytes(size)}")
    return Extent(chosen, without)


def _lacking(run: Run, episodes: Sequence[int], tell: Callable[[str], None]) -> tuple[Table, ...]:
    """The tables that a page cannot show as the run was not to keep them, or not all that it takes."""
    without: tuple[Table, ...] = ()
    if why := no_pheromones(run, episodes):
        without += _MARKS
        tell(f"{run.path}: the page shows no pheromones: {why}")
    elif any(
        (name.endswith("_half_life") and value is not None) or (name.endswith("_diffusion") and value)
        for name, value in run.scenario.parameters.items()
    ):
        what = "marks fade with time or spread in this run"
        tell(f"{run.path}: {what}; the page shows each as it was when it was last written")
    if why := run.missing("decisions"):
        without += ("decisions",)
        tell(f"{run.path}: the page shows no decisions: {why}")
    if run.manifest["backend"] != "nodeworld" and (why := run.missing("poses")):
        tell(f"{run.path}: the page shows no bodies: {why}")
    return without


def _light(
    run: Run,
    sizes: _Sizes,
    chosen: Sequence[int],
    without: tuple[Table, ...],
    tell: Callable[[str], None],
    room: Room,
) -> tuple[Table, ...]:
    """What is left out of an episode that is too large alone: pheromones first, then decisions."""
    parts: tuple[tuple[str, tuple[Table, ...]], ...] = (("pheromones", _MARKS), ("decisions", ("decisions",)))
    for what, tables in parts:
        size = _size(sizes, chosen, without)
        if size > room.usual and _size(sizes, chosen, (*without, *tables)) < size:
            without += tables
            tell(
                f"{run.path}: with its {what} the page would take about {_megabytes(size)}; it leaves them out. "
                f"Ask for them with {room.example.format(chosen[-1])}."
            )
    return without


def check_extent(run: Run, episodes: Sequence[int], what: str) -> None:
    """Refuses what would take too much memory.

    Args:
        run: The run.
        episodes: Which of its episodes.
        what: What is made of them, for the message: "a recording".

    Raises:
        TraceError: It is too much.
    """
    _check(run, _sizes(run), episodes, what, Room(USUAL, MOST))


def _check(
    run: Run, sizes: _Sizes, chosen: Sequence[int], what: str, room: Room, without: Sequence[Table] = ()
) -> float:
    size = _size(sizes, chosen, without)
    if size > room.most:
        hint = f"choose fewer with {room.option}" if len(chosen) > 1 else "run it again and --record less"
        named = f"these {len(chosen)} episodes" if len(chosen) > 1 else f"episode {next(iter(chosen))} alone"
        takes = f"would take about {_megabytes(size)}, at most {_megabytes(room.most)}"
        raise TraceError(f"{run.path}: {what} of {named} {takes}; {hint}")
    return size


def _size(sizes: _Sizes, episodes: Sequence[int] | _Sizes, without: Sequence[Table] = ()) -> float:
    """Bytes of some episodes."""
    parts = (sizes.get(number, {}) for number in episodes)
    return sum(size for part in parts for table, size in part.items() if table not in without)


def _sizes(run: Run) -> _Sizes:
    """About how many bytes of a page each table of each complete episode takes."""
    sizes: _Sizes = {result.episode: {} for result in run.episodes}
    for table, each in _ROW.items():
        for episode, rows in ({} if run.missing(table) else run.rows_by_episode(table)).items():
            # The values at the end of an episode are those that the next one begins with.
            number = episode + 1 if table == "frames" else episode
            if number in sizes:
                sizes[number][table] = each * rows
    return sizes


def _last_that_fit(sizes: Mapping[int, float], usual: float) -> list[int]:
    chosen: list[int] = []
    taken = 0.0
    for number in sorted(sizes, reverse=True):
        taken += sizes[number]
        if chosen and taken > usual:
            break
        chosen.insert(0, number)
    return chosen


def _megabytes(size: float) -> str:
    return f"{size / 1e6:.0f} MB"
