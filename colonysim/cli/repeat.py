"""`colonysim repeat`: run a recorded run again."""

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
  colonysim run hard --live --out runs/lesson
  colonysim repeat runs/lesson
  colonysim repeat runs/lesson --out runs/again
"""


def command(
    path: Annotated[Path, typer.Argument(metavar="RUN", help="A run directory.", show_default=False)],
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", "-o", metavar="DIR", help="Where to record; absent or empty. [default: a new directory in runs/]"
        ),
    ] = None,
    policy: PolicyOfOthers = None,
    backend: BackendOfOthers = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print the result only, no progress.")] = False,
) -> None:
    """Run a recorded run again, with everything that was done to it by hand, and compare the two.

    What was changed on the page of `run --live` comes at the same moments. The exit code is 0 if all
    that was recorded came again, else 2.
    """
    from contextlib import ExitStack

    from colonysim.cli.console import print_result, say
    from colonysim.cli.run import shown_progress
    from colonysim.cli.stopping import told_when_stopped
    from colonysim.files import shown_path
    from colonysim.repeating import first_difference, repeat
    from colonysim.trace.reader import Run

    bars: list[Callable[[Event, Run], None]] = []
    with told_when_stopped(lambda: "Interrupted."), ExitStack() as shown:

        def starts(run: Run) -> None:
            about = run.manifest
            bars.append(shown.enter_context(shown_progress(run.scenario, about["backend"], about["episodes"], quiet)))

        again = repeat(
            path, out=out, policy=policy, backend=backend, on_start=starts,
            on_event=lambda event, run: bars[0](event, run),
        )  # fmt: skip
    before = Run.open(path)
    place, count = shown_path(again.path or path), len(again.manifest.get("by_hand") or ())
    by_hand = f", {count} {'change' if count == 1 else 'changes'} by hand among it" if count else ""
    differs = first_difference(before, again)
    if differs is None:
        what = "all that was recorded came again" if before.status != "finished" else "came out the same"
        print_result(f"{shown_path(path)}: {what}{by_hand}: {place}, trace_sha256 {again.trace_sha256}")
        return
    where = "in a table other than the events" if differs < 0 else f"from event {differs} on"
    say(f"Error: {shown_path(path)}: came out otherwise, {where}: {place}")
    raise SystemExit(2)
