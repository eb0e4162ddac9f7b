"""`colonysim reproduce`: the paper's tables and figures beside ours."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from colonysim.cli.extras import EngineOption

if TYPE_CHECKING:
    from colonysim.sweep.workers import Outcome

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim reproduce --quick --out results/paper
  colonysim reproduce ablation-sanity asynchrony --out results/paper
  colonysim reproduce performance-physics --physics docs/results/bullet.jsonl --out results/paper
  colonysim reproduce --list
"""


def command(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="[NAME]...", help="What to reproduce; see --list.", show_default="all")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="DIR", help="Where report, images, trials and runs go.")
    ] = None,
    list_only: Annotated[bool, typer.Option("--list", help="List what can be reproduced.")] = False,
    quick: Annotated[bool, typer.Option("--quick", help="Fewer seeds and episodes: some minutes.")] = False,
    seeds: Annotated[
        int | None, typer.Option(min=1, help="Seeds on the node world.", show_default="80, quick 8")
    ] = None,
    first_seed: Annotated[int, typer.Option(min=0, help="The first of all seeds.")] = 1000,
    workers: Annotated[
        int | None, typer.Option("--workers", "-w", min=1, help="Trials at a time. [default: one for each processor]")
    ] = None,
    engine: EngineOption = None,
    physics: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FILE",
            help="Runs in physics that were stored (JSON lines) instead of running them; once for each engine.",
        ),
    ] = None,
    trainings: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Stored trainings of the push (JSON lines).", show_default="the package's"),
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")] = False,
) -> None:
    """Set every table and figure of the paper beside ours, and say what agrees.

    The report is written as Markdown and as one HTML file. Stop it at any moment and start it again: what has
    been run is kept. The same directory may hold a quick reproduction first and a full one later.
    """
    from dataclasses import replace

    from colonysim.cli.console import print_result, print_table, say
    from colonysim.cli.extras import need
    from colonysim.cli.stopping import go_on, told_when_stopped
    from colonysim.errors import ColonysimError
    from colonysim.physics import default_engine
    from colonysim.progress import Bar
    from colonysim.reproduce.judging import WORDS
    from colonysim.reproduce.making import STUDIES, reproduce
    from colonysim.reproduce.plans import FULL, QUICK

    if list_only:
        if names or out is not None or quick or seeds is not None or engine or physics or trainings is not None:
            raise ColonysimError("--list stands alone: nothing is reproduced")
        print_table(["name", "what", "in the paper"], [[k, s.title, s.places] for k, s in STUDIES.items()])
        return
    if out is None:
        raise ColonysimError("expected --out DIR")
    need("matplotlib", "plot", "drawing")
    size = replace(QUICK if quick else FULL, first_seed=first_seed, engine=engine or default_engine())
    if seeds is not None:
        size = replace(size, seeds=seeds, near_seeds=0)
    with Bar("trials", 1.0, quiet) as bar:

        def watch(outcome: Outcome, done: int, total: int) -> None:
            bar.move(done, total)
            if outcome.status == "failed":
                reason = outcome.error.strip().splitlines()[-1]
                bar.line(f"failed: {outcome.trial.scenario} seed {outcome.trial.seed}: {reason}")

        with told_when_stopped(lambda: go_on(out)):
            made = reproduce(
                out, names or (), size=size, workers=workers, physics=physics or (), trainings=trainings,
                on_outcome=watch, on_study=lambda name: bar.line(f"writing {name}"),
            )  # fmt: skip
    for gap in made.gaps:
        say(f"missing: {gap}")
    counts = ", ".join(f"{made.verdicts[word]} {word}" for word in WORDS)
    print_result(f"{counts}: {made.markdown}, {made.html}")
