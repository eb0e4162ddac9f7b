"""How large a page becomes, by the rows of its episodes and before any of them is read."""

from __future__ import annotations

from typing import TYPE_CHECKING

from colonysim.errors import TraceError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from colonysim.trace.reader import Run
    from colonysim.trace.schema import Table

__all__ = ["check_extent", "choose_episodes"]

_ROW: dict[Table, float] = {"events": 10.0, "decisions": 12.0, "deposits": 5.0, "poses": 3.0, "frames": 1.5}
"""Bytes of a page that a row of each table takes, as measured on the maps that are shipped, rounded up."""
USUAL = 20e6
"""Bytes of a page that nobody asked for in particular; a browser opens it at once."""
MOST = 100e6
"""Bytes of the largest page; making it takes some 3 GB of memory."""


def choose_episodes(run: Run, episodes: Sequence[int] | None, tell: Callable[[str], None]) -> Sequence[int] | None:
    """The episodes that a page shows: those that were asked for, else the last ones that fit.

    Args:
        run: The run.
        episodes: Which; None for as many as fit.
        tell: Is told what is left out, or how large the page will be if it is large.

    Raises:
        TraceError: They make a page that is too large.
    """
    everything = sum(_ROW[table] * run.manifest["rows"].get(table, 0) for table in _ROW)
    if run.status != "running" and everything <= USUAL:
        return episodes
    sizes = _sizes(run)
    if episodes is None and sum(sizes.values()) > USUAL:
        episodes = _last_that_fit(sizes)
        first, last = episodes[0], episodes[-1]
        shown = f"the last {len(episodes)}, {first} to {last}" if first != last else f"the last, {last}"
        tell(
            f"{run.path}: a page of all {len(sizes)} episodes would take about {_megabytes(sum(sizes.values()))}; "
            f"it shows {shown}. Choose others with --episodes."
        )
    size = _check(run, sizes, episodes, "a page")
    if size > USUAL:
        tell(f"{run.path}: the page will take about {_megabytes(size)}")
    return episodes


def check_extent(run: Run, episodes: Sequence[int], what: str) -> None:
    """Refuses what would take too much memory.

    Args:
        run: The run.
        episodes: Which of its episodes.
        what: What is made of them, for the message: "a recording".

    Raises:
        TraceError: It is too much.
    """
    _check(run, _sizes(run), episodes, what)


def _check(run: Run, sizes: Mapping[int, float], episodes: Sequence[int] | None, what: str) -> float:
    chosen = sizes if episodes is None else set(episodes)
    size = sum(sizes.get(number, 0.0) for number in chosen)
    if size > MOST:
        hint = "choose fewer with --episodes" if len(chosen) > 1 else "run it again with --no-decisions"
        named = f"these {len(chosen)} episodes" if len(chosen) > 1 else f"episode {next(iter(chosen))} alone"
        raise TraceError(
            f"{run.path}: {what} of {named} would take about {_megabytes(size)}, at most {_megabytes(MOST)}; {hint}"
        )
    return size


def _sizes(run: Run) -> dict[int, float]:
    """About how many bytes of a page each complete episode takes."""
    sizes = {result.episode: 0.0 for result in run.episodes}
    for table, each in _ROW.items():
        for episode, rows in run.rows_by_episode(table).items():
            # The values at the end of an episode are those that the next one begins with.
            number = episode + 1 if table == "frames" else episode
            if number in sizes:
                sizes[number] += each * rows
    return sizes


def _last_that_fit(sizes: Mapping[int, float]) -> list[int]:
    chosen: list[int] = []
    taken = 0.0
    for number in reversed(list(sizes)):
        taken += sizes[number]
        if chosen and taken > USUAL:
            break
        chosen.insert(0, number)
    return chosen


def _megabytes(size: float) -> str:
    return f"{size / 1e6:.0f} MB"
