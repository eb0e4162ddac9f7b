"""`colonysim train`: the push skill, the two estimates that say whether a push will work, and a colony's policy."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from colonysim.cli.extras import EngineOption

if TYPE_CHECKING:
    from colonysim.push.training.trainer import Progress
    from colonysim.rl.training.trainer import Progress as PolicyProgress

__all__ = ["app"]

_PUSH = """\b
Examples:
  colonysim train push --out models/mine
  colonysim train push --preset paper --seed 3 --out models/paper
  colonysim train push --engine mujoco --out models/mine
  colonysim train push --out models/mine --resume
  colonysim train push --set actions=20000 --set learner.learning_rate=0.0003 --out models/short
"""
_FEASIBILITY = """\b
Example:
  colonysim train feasibility --seed 1 --out models/feasibility
"""
_WAY = """\b
Examples:
  colonysim train way --seed 1 --out models/way
  colonysim train way --seed 1 --ways 1000 --out models/way
"""
_POLICY = """\b
Examples:
  colonysim train policy --out models/mine
  colonysim train policy --out models/mine --resume
  colonysim train policy --set ppo.iterations=100 --set hidden="[32, 32]" --out models/short
  colonysim run hard --policy learned --set policy.model=models/mine/policy.json
"""

app = typer.Typer(
    help="Train the push, an estimate that foresees its success, or a policy of the agents.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@app.command("push", epilog=_PUSH)
def push(
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="DIR", help="Where to write model, history and checkpoint.")
    ],
    preset: Annotated[str, typer.Option(help="A named configuration: improved or paper.")] = "improved",
    engine: EngineOption = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set", metavar="KEY=VALUE", help="Set a parameter of the preset, such as actions=300; may be given again."
        ),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", "-s", help="Makes the training.")] = 0,
    resume: Annotated[bool, typer.Option("--resume", help="Go on from the checkpoint in DIR.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")] = False,
) -> None:
    """Train the push by reinforcement learning (Double DQN).

    Writes the network as plain arrays with a JSON card, which names the engine. A training that was
    stopped, with Ctrl-C for instance, goes on from its last checkpoint with --resume. `colonysim plot
    DIR` draws its learning curve, also while it is under way.
    """
    from dataclasses import replace

    from colonysim.cli.console import print_result
    from colonysim.cli.extras import need, need_engine
    from colonysim.cli.settings import with_push_settings
    from colonysim.cli.stopping import told_when_stopped
    from colonysim.errors import ColonysimError
    from colonysim.progress import Bar
    from colonysim.suggest import nearest

    used = need_engine(engine)
    need("torch", "train", "training")
    from colonysim.push.training.presets import PRESETS
    from colonysim.push.training.trainer import train_push

    if preset not in PRESETS:
        raise ColonysimError(f"no preset {preset!r}; {nearest(preset, PRESETS)}")
    config = with_push_settings(replace(PRESETS[preset], engine=used), settings or ())
    if not resume and (out / "checkpoint.npz").exists():
        raise ColonysimError(f"{out}: holds a training already; go on with it (--resume), or choose another --out")
    with Bar(f"training the push ({preset})", 1.0, quiet) as bar:

        def show(progress: Progress) -> None:
            kinds = ", ".join(f"{kind} {rate:.2f}" for kind, rate in progress.by_kind.items())
            bar.line(
                f"{progress.episodes:5d} episodes: success {progress.success:.2f} ({kinds}), "
                f"reward {progress.reward:.2f}, epsilon {progress.epsilon:.3f}"
            )
            bar.move(progress.share)

        with told_when_stopped(lambda: _interrupted(out)):
            trained = train_push(config, out, seed, resume=resume, on_progress=show)
    if trained is not None:
        print_result(f"{trained.card}: best after {trained.peak_episode} episodes")


@app.command("feasibility", epilog=_FEASIBILITY)
def feasibility(
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="Where to write the model.")],
    model: Annotated[str, typer.Option("--model", metavar="FILE", help="The push that is judged.")] = "push",
    engine: EngineOption = None,
    states: Annotated[int, typer.Option("--states", min=200, help="Learn from at least so many states.")] = 10_000,
    seed: Annotated[int, typer.Option("--seed", "-s", help="Makes the training.")] = 0,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")] = False,
) -> None:
    """Train the classifier that foresees whether a push will succeed.

    It learns from states of pushes by the trained network. Its card holds the figures of five folds that
    never split an episode.
    """
    from colonysim.cli.console import print_result
    from colonysim.cli.extras import need, need_engine
    from colonysim.progress import Bar

    used = need_engine(engine)
    need("sklearn", "train", "training")
    from colonysim.push.training.forest import train_feasibility

    with Bar("gathering states", states, quiet) as bar:
        card = train_feasibility(
            out, seed, model=model, states=states, engine=used, on_progress=lambda done, _: bar.move(done)
        )
    print_result(str(card))


@app.command("way", epilog=_WAY)
def way(
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="Where to write the log and the model.")],
    model: Annotated[str, typer.Option("--model", metavar="FILE", help="The network that pushes.")] = "push",
    engine: EngineOption = None,
    ways: Annotated[int, typer.Option("--ways", min=20, help="How many ways to push a box along.")] = 600,
    seed: Annotated[int, typer.Option("--seed", "-s", help="Makes the ways.")] = 0,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")] = False,
) -> None:
    """Fit the calibrated chance of a whole way to pushes in cramped surroundings.

    The log, ways.jsonl, grows a line a way; the same command goes on where it was stopped. The card holds
    the calibration curve and the false-accept rates of five folds that never split a way.
    """
    from colonysim.cli.console import print_result
    from colonysim.cli.extras import need, need_engine
    from colonysim.progress import Bar

    used = need_engine(engine)
    need("sklearn", "train", "fitting")
    from colonysim.push.training.calibration import train_way_chance

    with Bar("pushing along ways", ways, quiet) as bar:
        card = train_way_chance(
            out, seed, model=model, ways=ways, engine=used, on_progress=lambda done, _: bar.move(done)
        )
    print_result(str(card))


@app.command("policy", epilog=_POLICY)
def policy(
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="DIR", help="Where to write models, history and checkpoint.")
    ],
    preset: Annotated[
        str, typer.Option(help="A named configuration: small, or tiny, which only shows that it works.")
    ] = "small",
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUE",
            help="Set a parameter of the preset, such as ppo.iterations=100; may be given again.",
        ),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", "-s", help="Makes the training.")] = 0,
    resume: Annotated[bool, typer.Option("--resume", help="Go on from the checkpoint in DIR.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")] = False,
) -> None:
    """Train a policy of a colony's agents: imitate the rule `colony`, then improve on it (PPO).

    One network decides for all agents, each from what it sees itself; rewards are discounted by simulated
    time. It learns on small worlds that are made for it, and is tested on others. Writes plain arrays with a
    JSON card, which `run --policy learned` runs without PyTorch. A training that was stopped goes on from its
    last checkpoint with --resume.
    """
    from colonysim.cli.console import print_result
    from colonysim.cli.extras import need
    from colonysim.cli.settings import with_settings
    from colonysim.cli.stopping import told_when_stopped
    from colonysim.errors import ColonysimError
    from colonysim.progress import Bar
    from colonysim.suggest import nearest

    need("torch", "train", "training")
    from colonysim.rl.training.presets import PRESETS
    from colonysim.rl.training.trainer import train_policy

    if preset not in PRESETS:
        raise ColonysimError(f"no preset {preset!r}; {nearest(preset, PRESETS)}")
    config = with_settings(PRESETS[preset], settings or ())
    if not resume and (out / "checkpoint.npz").exists():
        raise ColonysimError(f"{out}: holds a training already; go on with it (--resume), or choose another --out")
    with Bar(f"training a policy ({preset})", 1.0, quiet) as bar:

        def show(progress: PolicyProgress) -> None:
            if progress.tested is not None or progress.phase == "imitation":
                bar.line(_told(progress))
            bar.move(progress.share)

        with told_when_stopped(lambda: _interrupted(out)):
            trained = train_policy(config, out, seed, resume=resume, on_progress=show)
    if trained is not None:
        print_result(f"{trained.card}: best after {trained.best_round} iterations")


def _interrupted(out: Path) -> str:
    """What to say of a training that was stopped."""
    kept = (out / "checkpoint.npz").exists()
    after = "Go on from its last checkpoint with --resume." if kept else "There was no checkpoint yet."
    return f"Interrupted. {after}"


def _told(progress: PolicyProgress) -> str:
    """A line of a policy's training."""
    parts = [f"{progress.phase} {progress.round}", f"{progress.decisions} decisions"]
    if progress.tested is not None:
        parts.append(f"tested: success {progress.tested.success:.3f}, makespan {progress.tested.seconds:.1f} s")
    parts += [f"{name} {value:.3f}" for name, value in progress.told.items()]
    return ", ".join(parts)
