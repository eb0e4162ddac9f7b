"""`colonysim fork`: what would have become of a run if something had changed at one moment of it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from colonysim.cli.extras import BackendOfOthers, PolicyOfOthers

if TYPE_CHECKING:
    from colonysim.sweep.workers import Outcome

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim fork runs/hard-nodeworld-s0-1 --at 20 --set policy.beta=1 --out results/beta
  colonysim fork runs/hard-nodeworld-s0-1 --at 20 --episode 3 --episodes 3 --seeds 0-99 --out results/chance
  colonysim compare results/beta --by policy.beta
"""


def command(
    path: Annotated[Path, typer.Argument(metavar="RUN", help="A run directory.", show_default=False)],
    at: Annotated[
        float, typer.Option(metavar="SECONDS", help="The moment, simulated seconds of the episode.", show_default=False)
    ],
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="The sweep's directory.", show_default=False)],
    episode: Annotated[int, typer.Option(min=1, help="Its episode.")] = 1,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUE",
            help="Change a field of the scenario at that moment, such as policy.beta=1; may be given again.",
        ),
    ] = None,
    seeds: Annotated[str, typer.Option(metavar="LIST", help="One future for each: 0-19, or 1,3,10.")] = "0-19",
    episodes: Annotated[
        int | None, typer.Option("--episodes", "-n", min=1, help="Where they end. [default: where the run did]")
    ] = None,
    policy: PolicyOfOthers = None,
    backend: BackendOfOthers = None,
    workers: Annotated[
        int | None, typer.Option("--workers", "-w", min=1, help="Futures at a time. [default: one for each processor]")
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")] = False,
) -> None:
    """Play the futures of a run from one moment on: as things were, and with a change, for the same seeds.

    Everything random is drawn anew from each seed. What may change are parameters of the policy, timing, max_steps,
    stall_seconds and time_limit; what is where stays. The futures are a sweep, for `compare` and `results`; run the
    same command again to go on with one that was stopped. The colony is brought to the moment first, from the run's
    checkpoint if there is one before it, or from its beginning.
    """
    from colonysim.cli.console import print_result, say
    from colonysim.cli.numbers import read_numbers
    from colonysim.cli.stopping import go_on, told_when_stopped
    from colonysim.files import shown_path
    from colonysim.progress import Bar
    from colonysim.sweep.futures import fork_run
    from colonysim.sweep.store import Store

    numbers = read_numbers(seeds)
    with Bar("futures", 1.0, quiet) as bar:

        def watch(outcome: Outcome, done: int, total: int) -> None:
            bar.move(done, total)
            if outcome.status == "failed":
                bar.line(f"failed: seed {outcome.trial.seed}: {outcome.error.strip().splitlines()[-1]}")

        if not quiet:
            say(f"Going through {shown_path(path)} to {at:g} s of episode {episode}")
        with told_when_stopped(lambda: go_on(out)):
            planned = fork_run(
                path, out, at=at, episode=episode, overrides=settings, seeds=numbers, episodes=episodes, policy=policy,
                backend=backend, workers=workers, on_outcome=watch,
            )  # fmt: skip
    entries = Store(out).entries
    failed = sum(entries[trial.identity]["status"] == "failed" for trial in planned.trials)
    print_result(f"{len(planned.trials) - failed} futures succeeded, {failed} failed: {out}")
    if settings and failed < len(planned.trials) and not quiet:
        say(f"What it changed: colonysim compare {out} --by {settings[0].partition('=')[0].strip()}")
    if failed:
        raise SystemExit(1)
