"""`colonysim evaluate`: how well single pushes go."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from colonysim.cli.extras import EngineOption

__all__ = ["app"]

_EXAMPLES = """\b
Examples:
  colonysim evaluate push --push staged --episodes 200
  colonysim evaluate push --push rl --model models/mine/push.npz --episodes 200 --seed 1 --json
  colonysim evaluate push --engine mujoco --episodes 200
  colonysim evaluate push --episodes 20 --out runs/pushes && colonysim plot runs/pushes
"""
_KEYS = ("episodes", "success", "success_low", "success_high", "reward_mean", "reward_sd")

app = typer.Typer(help="Measure how well single pushes go.", no_args_is_help=True, rich_markup_mode=None)


@app.callback()
def _top() -> None:
    # Keeps `push` a command of its own while it is the only one.
    pass


@app.command("push", epilog=_EXAMPLES)
def push(
    kind: Annotated[
        Literal["rl", "staged", "scripted"],
        typer.Option("--push", help="Learned, learned behind a scripted approach, or scripted."),
    ] = "staged",
    episodes: Annotated[int, typer.Option("--episodes", "-n", min=1, help="Pushes per terrain.")] = 200,
    seed: Annotated[int, typer.Option("--seed", "-s", help="Makes the episodes.")] = 0,
    model: Annotated[
        Path | None, typer.Option("--model", metavar="FILE", help="The network. [default: the one shipped]")
    ] = None,
    engine: EngineOption = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", "-o", metavar="DIR", help="Record the pushes there; absent or empty. [default: record nothing]"
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print results as one JSON object.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print results only, no progress.")] = False,
) -> None:
    """Measure success and reward of single pushes on flat ground, up a slope and into a hole.

    Success comes with its 95 % interval (Wilson). The starts are drawn apart from those of training.
    With --out poses and controls are recorded, for `colonysim plot` to draw trajectories from.
    """
    from contextlib import nullcontext

    from colonysim.cli.console import print_json, print_result, print_table
    from colonysim.cli.extras import need_engine
    from colonysim.cli.stopping import told_when_stopped
    from colonysim.progress import Bar

    used = need_engine(engine)
    from colonysim.errors import ColonysimError
    from colonysim.push.training.evaluation import evaluate_push

    if kind == "scripted" and model is not None:
        raise ColonysimError("--model: scripted pushes need no network")
    recorder = None
    if out is not None:
        from colonysim.cli.pushes import PushRecorder

        recorder = PushRecorder(out, kind, engine=used, episodes=episodes, seed=seed, model=model)
    done = 0
    with Bar(f"pushing ({kind})", 3 * episodes, quiet) as bar:

        def show(terrain: str, number: int, successes: int) -> None:
            nonlocal done
            done += 1
            bar.move(done)
            if number == episodes:
                bar.line(f"{terrain}: {successes} of {episodes} pushes succeeded")

        def told() -> str:
            where = "" if out is None else f" Those are recorded in {out}"
            return f"Interrupted after {done} of {3 * episodes} pushes.{where}"

        with told_when_stopped(told), nullcontext() if recorder is None else recorder:
            found = evaluate_push(
                kind, episodes=episodes, seed=seed, model=model, engine=used, on_progress=show, watch=recorder
            )
            results = {terrain: {key: values[key] for key in _KEYS} for terrain, values in found.items()}
            if recorder is not None:
                recorder.results(results)
    if as_json:
        print_json(results)
        return
    rows = [
        (
            terrain,
            f"{values['success']:.3f}",
            f"{values['success_low']:.3f} to {values['success_high']:.3f}",
            f"{values['reward_mean']:.2f} ± {values['reward_sd']:.2f}",
        )
        for terrain, values in results.items()
    ]
    title = f"push {kind} · {used} · {episodes} episodes per terrain · seed {seed}"
    print_table(("terrain", ">success", ">95 % interval", ">reward"), rows, title)
    if out is not None:
        print_result(f"recorded in {out}")
