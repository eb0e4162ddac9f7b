"""`colonysim tune`: settings that do well, looked for among ranges."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

if TYPE_CHECKING:
    from colonysim.sweep.tuning import Candidate
    from colonysim.sweep.workers import Outcome

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim tune beta.yaml --out results/tuned --measure steps --episodes 21-30
  colonysim results results/tuned

\b
A sweep file whose sample is chosen, not drawn:
  scenarios: [easy]
  sample: {count: 40, ranges: {policy.beta: [1, 16], policy.epsilon: [0.01, 0.9]}}
  seeds: {count: 8}
"""
_SHOWN = 10


def command(
    file: Annotated[Path, typer.Argument(help="A sweep file with a sample.", show_default=False)],
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="The sweep's directory.", show_default=False)],
    measure: Annotated[
        Literal["steps", "success", "sim_seconds"], typer.Option(help="What is made small, or with success large.")
    ] = "steps",
    episodes: Annotated[
        str | None, typer.Option(metavar="FIRST-LAST", help="Only these episodes count.", show_default="all")
    ] = None,
    workers: Annotated[
        int | None, typer.Option("--workers", "-w", min=1, help="Trials at a time. [default: one for each processor]")
    ] = None,
    engine: Annotated[Literal["local", "ray"], typer.Option(help="As for sweep.")] = "local",
    as_json: Annotated[bool, typer.Option("--json", help="Print all choices as JSON, the best first.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")] = False,
) -> None:
    """Look for settings with few steps or much success, each choice made by what came of those before.

    Stop it at any moment and start it again: what has been tried is kept. The best of many choices owes part of its
    figure to luck: judge it on seeds that were not used here.
    """
    from colonysim.cli.console import print_json, print_table
    from colonysim.cli.numbers import read_span
    from colonysim.cli.stopping import go_on, told_when_stopped
    from colonysim.errors import ColonysimError
    from colonysim.progress import Bar
    from colonysim.sweep.tuning import tune

    with Bar("choices", 1.0, quiet) as bar:

        def watch(outcome: Outcome, done: int, total: int) -> None:
            del done, total
            if outcome.status == "failed":
                bar.line(f"failed: seed {outcome.trial.seed}: {outcome.error.strip().splitlines()[-1]}")

        with told_when_stopped(lambda: go_on(out)):
            found = tune(
                file, out, measure=measure, episodes=read_span(episodes), workers=workers, engine=engine,
                on_outcome=watch, on_candidate=lambda _, number, count: bar.move(number, count),
            )  # fmt: skip
    if as_json:
        print_json([{**each.settings, measure: each.value} for each in found])
    else:
        columns = [*(f">{name}" for name in found[0].settings), f">{measure} [95 %]"]
        print_table(columns, [_cells(each) for each in found[:_SHOWN]])
    if found[0].value is None:
        raise ColonysimError(f"every choice had a trial that failed; see colonysim results {out}")


def _cells(each: Candidate) -> list[str]:
    cells = [f"{value:.4g}" for value in each.settings.values()]
    if each.value is None:
        return [*cells, "failed"]
    interval = "" if each.interval is None else " [{:.4g}, {:.4g}]".format(*each.interval)
    return [*cells, f"{each.value:.4g}{interval}"]
