"""`colonysim resume`: go on with a run that was stopped."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from colonysim.cli.extras import BackendOfOthers, PolicyOfOthers

if TYPE_CHECKING:
    from collections.abc import Callable

    from colonysim.trace.reader import Run
    from colonysim.trace.schema import Event

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim run hard --episodes 1000 --checkpoint-every 60s --out runs/long
  colonysim resume runs/long
  colonysim resume runs/mine --policy my_package.rules:Mine
"""


def command(
    path: Annotated[Path, typer.Argument(metavar="RUN", help="A run directory.", show_default=False)],
    policy: PolicyOfOthers = None,
    backend: BackendOfOthers = None,
    checkpoint_every: Annotated[
        str | None,
        typer.Option(
            metavar="TIME", help="Save the colony this often from now on: 60s, 5m, 2h.", show_default="as before"
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print results as one JSON object.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print results only, no progress.")] = False,
) -> None:
    """Go on with a run that was killed, stopped or has failed, from its last checkpoint.

    The finished run has the same hash as one that was never stopped. A run that was not to make checkpoints
    (`run --checkpoint-every`) begins anew in its directory; one that is finished stays as it is.
    """
    from contextlib import ExitStack

    from colonysim.cli.console import print_json, say
    from colonysim.cli.numbers import read_duration
    from colonysim.cli.run import shown_progress
    from colonysim.cli.stopping import told_when_stopped
    from colonysim.cli.summary import print_results, results
    from colonysim.files import shown_path
    from colonysim.resuming import resume

    def told() -> str:
        return f"Interrupted. `colonysim resume {shown_path(path)}` goes on again."

    every = None if checkpoint_every is None else read_duration("--checkpoint-every", checkpoint_every)
    bars: list[Callable[[Event, Run], None]] = []
    with told_when_stopped(told), ExitStack() as shown:

        def starts(run: Run) -> None:
            about = run.manifest
            bars.append(shown.enter_context(shown_progress(run.scenario, about["backend"], about["episodes"], quiet)))

        run = resume(
            path, policy=policy, backend=backend, on_start=starts, on_event=lambda event, run: bars[0](event, run),
            checkpoint_every=every,
        )  # fmt: skip
    if not bars:
        say(f"{shown_path(path)}: finished already; there is nothing to go on with")
    if as_json:
        print_json(results(run))
    else:
        print_results(run)
