"""`colonysim run`: run a scenario and record it."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

if TYPE_CHECKING:
    from collections.abc import Callable

    from colonysim.cli.watch import Watch
    from colonysim.progress import RunBar
    from colonysim.scenario.scenario import Scenario
    from colonysim.trace.kept import Kept
    from colonysim.trace.reader import Run
    from colonysim.trace.schema import Event
    from colonysim.view.controls import Controls
    from colonysim.view.live import Live

__all__ = ["EXAMPLES", "command", "shown_progress"]

EXAMPLES = """\b
Examples:
  colonysim run hard
  colonysim run hard --variant r5-6 --seed 7 --episodes 10 --json
  colonysim run my.yaml --policy paper --set policy.beta=2 --set detection_radius=20
  colonysim run hard --record events,frames
  colonysim run hard --episodes 1000 --checkpoint-every 60s
  colonysim run hard --watch
  colonysim run hard --backend physics --live
  colonysim run hard --backend mujoco --push staged --out runs/physics
  colonysim run hard --backend bullet --push rl --model models/mine/push.json
  colonysim run hard --backend physics --from runs/hard-nodeworld-s0-1 --episodes 3
"""

_PACE = 5.0
"""Simulated seconds a second, unless --pace says otherwise."""
_LONG = 5.0
"""After so many seconds a run in plain Python says how it would be shorter."""
_SCENARIO = "A scenario file, or the name of a scenario that comes with colonysim (`colonysim scenarios`)."


def command(
    scenario: Annotated[str, typer.Argument(help=_SCENARIO, show_default=False)],
    variant: Annotated[
        str | None,
        typer.Option("--variant", "-v", help="One of the scenario's variants."),
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUE",
            help="Set a field of the scenario, such as policy.beta=2; may be given again.",
        ),
    ] = None,
    backend: Annotated[
        str,
        typer.Option("--backend", "-b", help="What moves the robots; see `colonysim backends`."),
    ] = "nodeworld",
    policy: Annotated[
        str | None,
        typer.Option(
            "--policy",
            "-p",
            help="What decides: a name, or package.module:Name. [default: the scenario's]",
        ),
    ] = None,
    mode: Annotated[
        Literal["asynchronous", "synchronous"] | None,
        typer.Option(help="Agents act when they are ready, or all at once. [default: the scenario's]"),
    ] = None,
    episodes: Annotated[
        int | None,
        typer.Option("--episodes", "-n", min=1, help="How many. [default: the scenario's]"),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", "-s", help="Makes the run.")] = 0,
    start: Annotated[
        Path | None,
        typer.Option("--from", metavar="RUN", help="Start with the pheromones that this run ended with."),
    ] = None,
    push: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="How robots push: rl (learned), staged (learned behind a scripted approach), scripted, the name of "
            "one that is installed, or package.module:Name (physics only).",
        ),
    ] = None,
    model: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="The network that pushes: the card that `colonysim train push` wrote, or an ONNX file (physics only). "
            "[default: the one shipped]",
        ),
    ] = None,
    feasibility: Annotated[
        Literal["geometry", "forest", "way"] | None,
        typer.Option(
            help="What says whether a push is tried: the planner, the classifier, or a calibrated chance of the whole "
            "way (physics only). [default: forest for rl, way for staged, geometry for scripted]"
        ),
    ] = None,
    gui: Annotated[bool, typer.Option("--gui", help="Show the physics in a window (backend bullet only).")] = False,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", "-o", metavar="DIR", help="Where to record; absent or empty. [default: a new directory in runs/]"
        ),
    ] = None,
    no_trace: Annotated[bool, typer.Option("--no-trace", help="Record nothing; results only.")] = False,
    record: Annotated[
        str | None,
        typer.Option(
            metavar="TABLES",
            help="What to keep besides events and episodes: some of decisions, deposits, poses, controls, and frames "
            "or last-frames, parted by commas.",
            show_default="everything; of a large world less",
        ),
    ] = None,
    checkpoint_every: Annotated[
        str | None,
        typer.Option(
            metavar="TIME",
            help="Save the colony in the run directory this often, wall clock: 60s, 5m, 2h; `colonysim resume` goes on "
            "from there.",
            show_default="never",
        ),
    ] = None,
    no_decisions: Annotated[
        bool,
        typer.Option("--no-decisions", help="Deprecated, goes with 0.2: see --record.", hidden=True),
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print results as one JSON object.")] = False,
    watch: Annotated[
        bool, typer.Option("--watch", "-w", help="Draw the map live in the terminal (the node world slowed down).")
    ] = False,
    live: Annotated[
        bool,
        typer.Option(
            "--live",
            "-l",
            help="Follow the run in the browser, on the page of `colonysim view`; pause and change it there.",
        ),
    ] = False,
    pace: Annotated[
        float | None,
        typer.Option(
            min=0.0,
            help="Simulated seconds a second of a run that is watched; 0: all at once.",
            show_default="5.0 on the node world",
        ),
    ] = None,
    port: Annotated[
        int,
        typer.Option(min=0, max=65535, help="Where --live listens on this machine.", show_default="any that is free"),
    ] = 0,
    no_open: Annotated[bool, typer.Option("--no-open", help="With --live, say the page's address only.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print results only, no progress.")] = False,
) -> None:
    """Run a scenario and record it in a run directory.

    Progress goes to standard error, results to standard output. Ctrl-C ends the run (SIGTERM
    and a closed terminal do too); what it had recorded until then stays readable. With --live
    on a terminal the page is served until a Ctrl-C after the run. What is changed on that page
    is in the trace; `colonysim repeat` runs it again.

    Of a large world deposits, or the pheromones at the end of all episodes but the last, are
    left out unless --record names them; a line says so before the run begins.
    """
    from contextlib import ExitStack

    from colonysim.cli.console import print_json, say
    from colonysim.cli.numbers import read_duration
    from colonysim.cli.stopping import told_when_stopped
    from colonysim.cli.summary import print_results, results
    from colonysim.errors import Anew, ColonysimError
    from colonysim.files import shown_path
    from colonysim.recording import run
    from colonysim.scenario.contradictions import refuse_contradictions
    from colonysim.scenario.loading import load_scenario

    options = _backend_options(backend, push, model, feasibility, gui)
    if (port or no_open) and not live:
        raise ColonysimError(f"{'--port' if port else '--no-open'}: only with --live")
    slowed = backend == "nodeworld" and (watch or live)
    if pace is not None and not (slowed or live):
        raise ColonysimError("--pace: only a run with --live, or a node world with --watch, is slowed down")
    pace = (_PACE if slowed else 0.0) if pace is None else pace
    if no_trace and out is not None:
        raise ColonysimError("--no-trace and --out: the run is either recorded or not")
    if no_decisions and record is not None:
        raise ColonysimError("--no-decisions and --record: both say what is kept; leave out --no-decisions")
    if checkpoint_every is not None and no_trace:
        raise ColonysimError("--checkpoint-every and --no-trace: without a trace there is no directory to go on in")
    every = None if checkpoint_every is None else read_duration("--checkpoint-every", checkpoint_every)
    loaded = load_scenario(scenario, variant, settings)
    refuse_contradictions(loaded, {"--policy": policy, "--mode": mode, "--episodes": episodes})
    count = loaded.episodes if episodes is None else episodes
    kept = _kept(loaded, count, record, no_decisions)
    if kept.thinned and not quiet and not no_trace:
        say(f"Recorded {kept.why}; --record says otherwise.")
    begun: list[Run] = []
    with ExitStack() as open_until_the_end:
        page, controls = None, None
        if live:
            from colonysim.view.controls import Controls
            from colonysim.view.reading import no_pheromones

            controls = Controls(pace)
            page = open_until_the_end.enter_context(_page(port, controls))

        def starts(run: Run) -> None:
            begun.append(run)
            if page:
                page.begin(run)
                if len(begun) == 1:
                    _open(page, no_open)
                if why := no_pheromones(run, range(1, count + 1)):
                    say(f"The page shows no pheromones: {why}")

        def told() -> str:
            path = shown_path(begun[-1].path) if begun and begun[-1].path else ""
            where = f" The run so far is in {path}" if path else ""
            if path and every is not None:
                where += f"; `colonysim resume {path}` goes on with it"
            return f"Interrupted after {len(begun[-1].episodes) if begun else 0} of {count} episodes.{where}"

        again = True
        while again:
            try:
                with told_when_stopped(told), _shown(loaded, backend, count, watch, quiet) as shown:
                    slow = _slowed(shown, pace) if slowed and not live else shown
                    recorded = run(
                        loaded, backend=backend, policy=policy, mode=mode,
                        episodes=count, seed=seed, out=_anew(out, len(begun)), trace=not no_trace, record=kept,
                        initial=start, backend_options=options, on_start=starts, on_event=slow, tap=page,
                        attend=None if controls is None else controls.attend, checkpoint_every=every,
                    )  # fmt: skip
            except Anew:
                say(f"Begins anew. {told()}")
                continue
            if as_json:
                print_json(results(recorded))
            else:
                print_results(recorded)
                if not quiet:
                    _hint_at_compiling(recorded)
            again = bool(page and controls and _stays(page, controls))


def _anew(out: Path | None, before: int) -> Path | None:
    """Where a run is recorded that begins anew, after so many: beside the first, where there is nothing yet."""
    if out is None or not before:
        return out
    numbered = (out.with_name(f"{out.name}-{number}") for number in itertools.count(before + 1))
    return next(path for path in numbered if not path.exists())


def _stays(page: Live, controls: Controls) -> bool:
    """Serves the page of a run that is over, on a terminal until Ctrl-C; returns whether the run is to begin anew."""
    from colonysim.cli.console import on_terminal, say

    page.end()
    if page.trouble:
        say(f"Error: the run went on, but its page did not: {page.trouble}")
        raise SystemExit(1)
    if not on_terminal():
        return False
    say(f"The run is over; its page stays at {page.address} until Ctrl-C.")
    try:
        controls.wait_for_reset()
    except KeyboardInterrupt:
        return False
    return True


def _hint_at_compiling(run: Run) -> None:
    """Says after a long run in plain Python how it would be shorter."""
    from colonysim.built import build
    from colonysim.cli.console import say
    from colonysim.installing import compile_command

    if sum(episode.wall_seconds for episode in run.episodes) > _LONG and build().startswith("plain Python"):
        say(
            "This ran as plain Python. Compiled, the node world takes less than a tenth of the time and a physics"
            f" engine two thirds; a minute, once, with a C compiler: {compile_command()}"
        )


def _kept(scenario: Scenario, episodes: int, record: str | None, no_decisions: bool) -> Kept:
    """What the run keeps."""
    from colonysim.cli.console import say
    from colonysim.trace.kept import asked_for, by_size

    if record is not None:
        return asked_for(record)
    kept = by_size(scenario, episodes)
    if not no_decisions:
        return kept
    say("--no-decisions goes with colonysim 0.2; say what to keep with --record")
    return kept.without("decisions")


def _page(port: int, controls: Controls) -> Live:
    from colonysim.view.live import Live

    return Live(port, controls)


def _open(page: Live, no_open: bool) -> None:
    from colonysim.cli.console import say

    say(f"Live at {page.address}")
    if not no_open:
        import webbrowser

        webbrowser.open(page.address)


def _slowed(shown: Callable[[Event, Run], None], pace: float) -> Callable[[Event, Run], None]:
    from colonysim.cli.watch import Pace

    wait = Pace(pace)

    def slow(event: Event, run: Run) -> None:
        wait(event)
        shown(event, run)

    return slow


def _shown(scenario: Scenario, backend: str, episodes: int, watch: bool, quiet: bool) -> RunBar | Watch:
    """What is seen of the run while it goes on."""
    from colonysim.errors import ColonysimError

    if not watch:
        return shown_progress(scenario, backend, episodes, quiet)
    from colonysim.cli.console import on_terminal
    from colonysim.cli.watch import Watch

    if quiet:
        raise ColonysimError("--watch and --quiet: the run is either drawn or not")
    if not on_terminal():
        raise ColonysimError("--watch draws on a terminal, and standard error is none")
    return Watch(scenario, episodes)


def shown_progress(scenario: Scenario, backend: str, episodes: int, quiet: bool) -> RunBar:
    """A bar and a line for each episode."""
    from colonysim.cli.summary import episode_line
    from colonysim.progress import RunBar

    title = f"{scenario.name} on {_called(scenario, backend)}"
    return RunBar(title, episodes, scenario.max_steps, quiet, episode_line)


def _called(scenario: Scenario, backend: str) -> str:
    """The backend, of "physics" the engine that it will be."""
    if backend != "physics":
        return backend
    from colonysim.physics import default_engine

    return str(scenario.physics.get("engine") or default_engine())


def _backend_options(
    backend: str, push: str | None, model: Path | None, feasibility: str | None, gui: bool
) -> dict[str, Any]:
    from colonysim.engines import PACKAGES
    from colonysim.errors import ColonysimError
    from colonysim.files import shown_path

    options: dict[str, Any] = {}
    if push is not None:
        options["push"] = push
    if model is not None:
        options["model"] = shown_path(model)
    if feasibility is not None:
        options["feasibility"] = feasibility
    if gui:
        options["gui"] = True
    if options and backend == "nodeworld":
        named = " and ".join(f"--{name}" for name in options)
        physics = "bullet" if gui else "physics"
        raise ColonysimError(f"{named}: the node world has no bodies; add --backend {physics}")
    if gui and backend in PACKAGES:
        from colonysim.physics import window_trouble

        if trouble := window_trouble(backend):
            raise ColonysimError(f"--gui: {trouble}")
    return options
