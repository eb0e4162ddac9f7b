"""`colonysim sweep`: many runs of many settings, which survive whatever happens to them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim sweep beta.yaml --out results/beta
  colonysim sweep beta.yaml --out results/beta --retry failed
  RAY_ADDRESS=head:6379 colonysim sweep beta.yaml --out results/beta --engine ray
  colonysim results results/beta

\b
A sweep file:
  scenarios: [easy, {scenario: hard, variants: [null, r5-4]}]
  grid: {policy.beta: [2, 4, 8]}
  seeds: {count: 20}
"""


def command(
    file: Annotated[Path, typer.Argument(help="The sweep file.", show_default=False)],
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="The sweep's directory.", show_default=False)],
    workers: Annotated[
        int | None, typer.Option("--workers", "-w", min=1, help="Trials at a time. [default: one for each processor]")
    ] = None,
    engine: Annotated[
        Literal["local", "ray"],
        typer.Option(help="Processes of this machine, or the Ray cluster that RAY_ADDRESS names (else one here)."),
    ] = "local",
    retry: Annotated[Literal["failed"] | None, typer.Option(help="Run trials that failed once more.")] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")] = False,
) -> None:
    """Run all trials of a sweep that its directory does not hold yet.

    Stop it at any moment and start it again, also with another version of the file: finished trials
    are kept, the rest goes on. A trial that fails is a row with its traceback, and does not stop the others.
    """
    from colonysim.cli.console import print_result
    from colonysim.cli.stopping import go_on, told_when_stopped
    from colonysim.sweep import run_sweep

    with told_when_stopped(lambda: go_on(out)):
        planned, store = run_sweep(
            file, out, workers=workers, engine=engine, retry_failed=retry == "failed", progress=not quiet
        )
    failed = sum(store.entries[trial.identity]["status"] == "failed" for trial in planned.trials)
    print_result(f"{len(planned.trials) - failed} trials succeeded, {failed} failed: {out}")
    if failed:
        raise SystemExit(1)
