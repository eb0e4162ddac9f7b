"""The results of a sweep by group of agents: each trial as many times as its scenario has groups."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from colonysim.errors import ColonysimError
from colonysim.sweep.tables import has_groups, read_table, read_tables
from colonysim.trace.fields import MOST

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

__all__ = ["are_groups", "read_by_group"]

_LONGEST = 1000
"""Characters of a group's name at most; scenarios take far fewer."""


def are_groups(value: Any) -> bool:
    """Whether a value is a list of what a `GroupResult` holds, as trials give it."""
    return isinstance(value, list) and all(isinstance(row, list) and len(row) == 5 and _is_group(*row) for row in value)


def _is_group(episode: Any, name: Any, agents: Any, success: Any, steps: Any) -> bool:
    wholes = all(type(number) is int and 0 <= number <= MOST for number in (episode, agents, steps))
    within = isinstance(success, (int, float)) and not isinstance(success, bool) and 0.0 <= success <= 1.0
    return wholes and within and isinstance(name, str) and len(name) <= _LONGEST


def read_by_group(directory: str | Path) -> tuple[Any, Any]:
    """The tables of trials and episodes with a column `group` more, and a row for each group instead of one.

    A trial without groups, or that has not been played, is one row whose group is null.

    Raises:
        ColonysimError: The sweep has no groups, there are no results, or a table is damaged.
    """
    import pyarrow as pa

    trials, _ = read_tables(directory)
    if not has_groups(directory):
        raise ColonysimError(f"{directory}: no scenario of this sweep has groups of agents")
    results = read_table(directory, "groups").to_pylist()
    names: dict[str, dict[str, None]] = {}
    for row in results:
        names.setdefault(row["trial"], {})[row["group"]] = None
    rows = [
        _in_order({**row, "trial": _both(row["trial"], group), "group": group}, trials.column_names)
        for row in trials.to_pylist()
        for group in names.get(row["trial"], {None: None})
    ]
    played = [
        {"trial": _both(row["trial"], row["group"]), **{name: row[name] for name in ("episode", "success", "steps")}}
        for row in results
    ]
    return pa.Table.from_pylist(rows), pa.Table.from_pylist(played)


def _both(trial: str, group: str | None) -> str:
    return trial if group is None else f"{trial} {group}"


def _in_order(row: Mapping[str, Any], names: list[str]) -> dict[str, Any]:
    """A row whose group stands before the trial's status: there end the columns that tell what was run."""
    at = names.index("status")
    return {name: row[name] for name in (*names[:at], "group", *names[at:])}
