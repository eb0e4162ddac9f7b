"""`colonysim compare`: the difference that one setting makes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from colonysim.sweep.comparing import Difference

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim compare results/presets --by policy --episodes 21-30
  colonysim compare results/before results/after
  colonysim compare results/presets --by policy --by-group
  colonysim compare results/presets --by group
  colonysim compare runs/hard-nodeworld-s0-1 runs/hard-bullet-s0-1
"""
_DIGITS = {"success": 3, "steps": 1, "sim_seconds": 1}


def command(
    paths: Annotated[list[Path], typer.Argument(metavar="DIR...", help="Runs and sweeps.", show_default=False)],
    by: Annotated[
        list[str] | None,
        typer.Option(
            help="What is compared: one setting, version, group (of agents), or source (the directory).",
            show_default="what varies, or the directories",
        ),
    ] = None,
    episodes: Annotated[
        str | None, typer.Option(metavar="FIRST-LAST", help="Only these episodes.", show_default="all")
    ] = None,
    by_group: Annotated[bool, typer.Option("--by-group", help="Compare each group of agents for itself.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print rows as JSON.")] = False,
) -> None:
    """Print the difference between policies, backends, versions or other settings, seed by seed.

    Runs and trials are paired that have the same seed, and the same settings but for what is compared. The interval is
    of 95 % over seeds (bootstrap from 8 on, Student's t for fewer); with one seed there is none.
    `--by-group` compares success and steps group by group, `--by group` the groups with each other.
    """
    from colonysim.cli.console import print_json, print_table
    from colonysim.cli.numbers import read_span
    from colonysim.cli.opening import opened
    from colonysim.errors import ColonysimError
    from colonysim.sweep.comparing import compare
    from colonysim.trace.manifest import is_run

    if len(by or ()) > 1:
        raise ColonysimError(
            f"--by: given {len(by or ())} times ({', '.join(by or ())}), expected the one that is compared"
        )
    for path in paths:
        if is_run(path):
            opened(path)  # tells of those that are not finished
    found = compare(paths, by=by[0] if by else None, episodes=read_span(episodes), by_group=by_group)
    if as_json:
        print_json([_as_json(each) for each in found])
        return
    free = list(found[0].where)
    columns = [*free, found[0].by, "against", "measure", ">it", ">against it", ">difference [95 %]", ">seeds"]
    print_table(columns, [[*(_word(each.where[name]) for name in free), *_cells(each)] for each in found])


def _cells(each: Difference) -> list[str]:
    digits = _DIGITS[each.measure]
    low_high = "" if each.interval is None else " [{:+.{d}f}, {:+.{d}f}]".format(*each.interval, d=digits)
    means = [f"{mean:.{digits}f}" for mean in reversed(each.means)]
    difference = f"{each.difference:+.{digits}f}{low_high}"
    return [_word(each.other), _word(each.reference), each.measure, *means, difference, str(each.seeds)]


def _as_json(each: Difference) -> dict[str, Any]:
    low, high = each.interval or (None, None)
    return {
        **each.where, "by": each.by, "reference": each.reference, "other": each.other, "measure": each.measure,
        "reference_mean": each.means[0], "other_mean": each.means[1], "difference": each.difference,
        "difference_low": low, "difference_high": high, "seeds": each.seeds,
    }  # fmt: skip


def _word(value: Any) -> str:
    return "-" if value is None else str(value)
