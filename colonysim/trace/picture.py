"""A run in short, for notebooks: its map, what was run, and how its episodes went."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING

from colonysim.errors import ColonysimError
from colonysim.scenario.picture import map_at_start

if TYPE_CHECKING:
    from colonysim.trace.reader import Run
    from colonysim.trace.schema import EpisodeResult

__all__ = ["picture"]

_FIRST, _LAST = 3, 5
"""Episodes that are listed of a run with many."""


def picture(run: Run) -> str:
    """HTML of a run; of one that is damaged what is wrong, of one of single pushes no map."""
    try:
        place = "" if run.manifest.get("scenario") is None else map_at_start(run.scenario)
        episodes = run.episodes
    except ColonysimError as error:
        return f"<p>{html.escape(repr(run)[1:-1])}</p><p>{html.escape(str(error))}</p>"
    hash_ = f"<p>trace <code>{html.escape(run.trace_sha256)}</code></p>" if run.trace_sha256 else ""
    return f"<div>{place}<p>{html.escape(repr(run)[1:-1])}</p>{_table(episodes)}{hash_}</div>"


def _table(episodes: list[EpisodeResult]) -> str:
    if not episodes:
        return ""
    head = "".join(f"<th>{word}</th>" for word in ("episode", "steps", "success", "ended", "simulated s"))
    rows = [_row(each) for each in episodes]
    if len(rows) > _FIRST + _LAST + 1:
        left_out = f'<tr><td colspan="5" style="text-align: center">{len(rows) - _FIRST - _LAST} more</td></tr>'
        rows = [*rows[:_FIRST], left_out, *rows[-_LAST:]]
    return f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table>"


def _row(result: EpisodeResult) -> str:
    cells = (result.episode, result.steps, f"{result.success:.2f}", result.ended, f"{result.sim_seconds:.1f}")
    return f"<tr>{''.join(f'<td>{html.escape(str(cell))}</td>' for cell in cells)}</tr>"
