"""`colonysim sweep`: many runs of many settings, which survive whatever happens to them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

if TYPE_CHECKING:
    from colonysim.sweep import Store, Sweep

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim sweep beta.yaml --out results/beta
  colonysim sweep beta.yaml --out results/beta --retry failed
  RAY_ADDRESS=head:6379 colonysim sweep beta.yaml --out results/beta --engine ray
  colonysim sweep beta.yaml --out results/beta --shard 2/8
  colonysim sweep beta.yaml --out results/beta --merge
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
    shard: Annotated[
        str | None,
        typer.Option(metavar="I/N", help="Run part I of N only; the parts may run at once on machines that share DIR."),
    ] = None,
    merge: Annotated[bool, typer.Option("--merge", help="Run nothing: join what the shards have found.")] = False,
    partial: Annotated[bool, typer.Option("--partial", help="Merge also while trials are missing.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")] = False,
) -> None:
    """Run all trials of a sweep that its directory does not hold yet.

    Stop it at any moment and start it again, also with another version of the file: finished trials
    are kept, the rest goes on. A trial that fails is a row with its traceback, and does not stop the others.

    With `--shard` each of N commands, on as many machines, runs an N-th of the trials in a directory of its
    own below DIR, and goes on there when it is given again; `--merge` then writes the tables of all of them.
    """
    from colonysim.cli.stopping import go_on, told_when_stopped
    from colonysim.errors import ColonysimError
    from colonysim.sweep import run_sweep

    if partial and not merge:
        raise ColonysimError("--partial: only with --merge")
    if merge:
        if shard is not None or workers is not None or retry is not None or engine != "local":
            raise ColonysimError("--merge runs nothing: leave out --shard, --workers, --retry and --engine")
        _merge(file, out, partial)
        return
    with told_when_stopped(lambda: go_on(out)):
        planned, store = run_sweep(
            file, out, workers=workers, engine=engine, retry_failed=retry == "failed", shard=shard, progress=not quiet
        )
    _tell(planned, store)


def _merge(file: Path, out: Path, partial: bool) -> None:
    from colonysim.sweep import merge_shards

    planned, store, missing = merge_shards(file, out, partial=partial)
    _tell(planned, store, len(missing))


def _tell(planned: Sweep, store: Store, missing: int = 0) -> None:
    """Says what has come of the trials, and ends with exit code 1 if some have failed."""
    from colonysim.cli.console import print_result

    failed = sum(store.entries.get(trial.identity, {}).get("status") == "failed" for trial in planned.trials)
    left = f", {missing} missing" if missing else ""
    succeeded = len(planned.trials) - failed - missing
    print_result(f"{succeeded} trials succeeded, {failed} failed{left}: {store.directory}")
    if failed:
        raise SystemExit(1)
