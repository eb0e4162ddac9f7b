"""`colonysim compare`: the difference that one setting makes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from colonysim.sweep.comparing import Difference, Pooled

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim compare results/presets --by policy --episodes 21-30
  colonysim compare results/before results/after
  colonysim compare results/presets --by policy --by-group
  colonysim compare results/presets --by group
  colonysim compare runs/hard-nodeworld-s0-1 runs/hard-bullet-s0-1
"""


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
    as_json: Annotated[bool, typer.Option("--json", help="Print both as JSON.")] = False,
) -> None:
    """Print the difference between policies, backends, versions or other settings, seed by seed.

    Runs and trials are paired that have the same seed, and the same settings but for what is compared. First comes
    what it makes over all pairs, and what that means; then each setting by itself. The interval is
    of 95 % over pairs (bootstrap from 8 on, Student's t for fewer); with one pair there is none.
    `--by-group` compares success and steps group by group, `--by group` the groups with each other.
    """
    from colonysim.characters import printable
    from colonysim.cli.console import print_json, print_result, print_table
    from colonysim.cli.numbers import read_span
    from colonysim.cli.opening import opened
    from colonysim.errors import ColonysimError
    from colonysim.sweep.comparing import compare, pooled
    from colonysim.trace.manifest import is_run

    if len(by or ()) > 1:
        raise ColonysimError(
            f"--by: given {len(by or ())} times ({', '.join(by or ())}), expected the one that is compared"
        )
    for path in paths:
        if is_run(path):
            opened(path)  # tells of those that are not finished
    found = compare(paths, by=by[0] if by else None, episodes=read_span(episodes), by_group=by_group)
    over_all = pooled(found)
    if as_json:
        print_json({"pooled": [_pooled(each) for each in over_all], "differences": [_as_json(each) for each in found]})
        return
    heads = ["against", "measure", ">it", ">against it", ">difference [95 %]"]
    print_table(
        [*over_all[0].where, found[0].by, *heads, ">pairs", ">settings"],
        [
            [*map(_word, each.where.values()), *_cells(each), str(each.pairs), str(each.settings)] for each in over_all
        ], "over all seeds and settings",
    )  # fmt: skip
    for each in over_all:
        print_result(printable(each.sentence, 400))
    free = list(found[0].where)
    print_result("")
    print_table(
        [*free, found[0].by, *heads, ">seeds"],
        [[*(_word(row.where[name]) for name in free), *_cells(row), str(row.seeds)] for row in found],
        "each setting by itself",
    )  # fmt: skip


def _cells(each: Difference | Pooled) -> list[str]:
    from colonysim.sweep.comparing import DIGITS

    digits = DIGITS[each.measure]
    low_high = "" if each.interval is None else " [{:+.{d}f}, {:+.{d}f}]".format(*each.interval, d=digits)
    means = [f"{mean:.{digits}f}" for mean in reversed(each.means)]
    return [
        _word(each.other), _word(each.reference), each.measure, *means, f"{each.difference:+.{digits}f}{low_high}",
    ]  # fmt: skip


def _as_json(each: Difference) -> dict[str, Any]:
    return {**each.where, **_effect(each), "seeds": each.seeds}


def _pooled(each: Pooled) -> dict[str, Any]:
    return {**each.where, **_effect(each), "pairs": each.pairs, "settings": each.settings, "meaning": each.sentence}


def _effect(each: Difference | Pooled) -> dict[str, Any]:
    low, high = each.interval or (None, None)
    return {
        "by": each.by, "reference": each.reference, "other": each.other, "measure": each.measure,
        "reference_mean": each.means[0], "other_mean": each.means[1], "difference": each.difference,
        "difference_low": low, "difference_high": high,
    }  # fmt: skip


def _word(value: Any) -> str:
    from colonysim.sweep.played import AS_IT_WAS

    return AS_IT_WAS if value is None else str(value)
