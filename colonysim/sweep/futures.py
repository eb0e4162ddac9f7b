"""The futures of a recorded run: from one moment of it on, once as it was and once with a change, for many seeds."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from colonysim.arguments import as_seed, real, whole
from colonysim.errors import ColonysimError, TraceError
from colonysim.processes import refuse_unguarded
from colonysim.provenance import files_of, parts_of
from colonysim.recording import CHECKPOINT
from colonysim.resuming import anew, refuse_other_models, refuse_other_versions
from colonysim.simulation import Colony
from colonysim.simulation.keeping import loaded, saved_of
from colonysim.simulation.saving import read_saved, write_saved
from colonysim.simulation.settings import changed
from colonysim.states import Stored
from colonysim.sweep.plan import Limits, Sweep, Trial, identity
from colonysim.sweep.running import run_planned, warn_of_others
from colonysim.sweep.store import Store, holds_sweep
from colonysim.sweep.tables import STATE
from colonysim.trace.checks import LONGEST
from colonysim.trace.reader import Run
from colonysim.trace.schema import EVENT_KINDS

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from colonysim.simulation.saving import Saved
    from colonysim.sweep.workers import Outcome
    from colonysim.trace.schema import Event

__all__ = ["fork_run"]


def fork_run(
    path: str | Path,
    out: str | Path,
    *,
    at: float,
    episode: int = 1,
    overrides: Mapping[str, Any] | Sequence[str] | None = None,
    seeds: Sequence[int] = range(20),
    episodes: int | None = None,
    policy: str | None = None,
    backend: str | None = None,
    workers: int | None = None,
    on_outcome: Callable[[Outcome, int, int], None] | None = None,
) -> Sweep:
    """Plays the futures of a run from one of its moments on, as the trials of a sweep.

    The colony is brought to that moment as the run's manifest says, from its checkpoint if there is one before it, and
    what happens on the way is compared with what was recorded. Each seed then has one future as things were and, if
    there are `overrides`, one with these: `compare` shows what they changed, seed by seed. May be stopped and started
    again like any sweep. A script that calls this needs the usual `if __name__ == "__main__":`.

    Args:
        path: The run directory.
        out: The sweep's directory; holds the saved colony (`state.npz`) besides journal and tables.
        at: The moment, simulated seconds of the episode.
        episode: Its episode.
        overrides: Fields of the scenario that change then, as for `Colony.fork`.
        seeds: From which all that is random is drawn anew from that moment on.
        episodes: How many episodes the run is to have had in the end; by default as many as it was to have.
        policy: The policy, if it is code of others: a run directory does not have it imported by itself.
        backend: The backend, if it is code of others.
        workers: How many futures are played at a time; None for one for each processor.
        on_outcome: As for `run_sweep`.

    Returns:
        The sweep.

    Raises:
        ColonysimError: There is no such run or moment, a field cannot change under way, a part cannot be saved, or the
            directory holds other trials.
    """
    refuse_unguarded()
    run, second = Run.open(path), real("at", at, 0.0, LONGEST)
    manifest = run.manifest
    number = whole("episode", episode, 1, manifest["episodes"])
    count = manifest["episodes"] if episodes is None else whole("episodes", episodes, number, 10**9)
    drawn = list(dict.fromkeys(as_seed(seed, "seeds") for seed in seeds))
    if not drawn:
        raise ColonysimError("seeds: expected at least one")
    refuse_other_versions(manifest, Path(path))
    scenario = run.scenario
    refuse_other_models(manifest, scenario, Path(path))
    settings: dict[str, Any] = dict(changed(scenario, overrides).settings) if overrides else {}
    if "episodes" in settings:
        raise ColonysimError("episodes: how many there are is no change of one future; give it as episodes=")
    options = dict(manifest["options"].get("backend") or {})
    about: dict[str, Any] = {
        "run": [manifest[name] for name in ("scenario_sha256", "seed", "policy", "backend", "mode")] + [options],
        "episode": number, "at": second,
    }  # fmt: skip
    sources = files_of(scenario.parameters, options, scenario.parts_of_groups)
    if policy or backend:
        sources = parts_of(policy or scenario.policy, backend or manifest["backend"], scenario.parameters, options)
    plain = Trial(
        manifest["name"], manifest["variant"], backend or manifest["backend"], options, policy or manifest["policy"],
        manifest["mode"], {}, count, drawn[0], str(Path(out).absolute()), scenario.digest,
        sources=sources, start=about, given={"policy": policy, "backend": backend},
    )  # fmt: skip
    trials = [replace(plain, parameters=change, seed=seed) for change in ([{}, settings] if settings else [{}])
              for seed in drawn]  # fmt: skip
    planned = Sweep("futures", tuple(replace(trial, identity=identity(trial)) for trial in trials), Limits())
    file = Path(out) / STATE
    there = file.exists() and read_saved(file).extra == about
    if not there and (file.exists() or holds_sweep(out)):
        raise ColonysimError(f"{out}: holds trials of another sweep, or of another moment; expected a new directory")
    saved = None if there else _moment(run, number, second, about, policy, backend)
    with Store(out, write=True) as store:
        if saved is not None:
            write_saved(file, saved)
        run_planned(planned, store, workers=workers, on_outcome=on_outcome)
        warn_of_others(planned, store, "this fork")
    return planned


def _moment(
    run: Run, episode: int, at: float, about: Mapping[str, Any], policy: str | None, backend: str | None
) -> Saved:
    """A run's colony at a moment."""
    seen: list[Event] = []
    with _on_the_way(run, episode, at, policy, backend) as colony:
        within = colony.episode == episode  # from a checkpoint, which is the run's own
        for kind in EVENT_KINDS:
            colony.on(kind, lambda event, _: seen.append(event) if event.episode == episode else None)
        if colony.episode < episode and episode > 1:
            colony.run_until(episode=episode - 1)
        last = colony.run_until(time=at)
        if last is not None and last.kind == "episode":
            raise ColonysimError(f"{run.path}: episode {episode} ended at {colony.now:g} s, before {at:g} s")
        if not within:
            _check_same(run, episode, at, seen)
        return saved_of(colony, about)


def _check_same(run: Run, episode: int, at: float, seen: Sequence[Event]) -> None:
    """Checks that what happened up to a moment is what was recorded, as far as that goes."""
    recorded = list(run.events(episode)) if episode in run.rows_by_episode("events") else []
    recorded = [event for event in recorded if event.time <= at]
    common = max(len(recorded), len(seen)) if run.status == "finished" else min(len(recorded), len(seen))
    if recorded[:common] != list(seen[:common]):
        raise TraceError(
            f"{run.path}: gone through again, episode {episode} is another than was recorded: code of others has "
            "changed, or it was on another kind of machine"
        )


def _on_the_way(run: Run, episode: int, at: float, policy: str | None, backend: str | None) -> Colony:
    """The colony of a run before a moment: at its checkpoint, or at its very beginning."""
    assert run.path is not None
    source = run.path / CHECKPOINT
    if source.exists():
        saved = read_saved(source)
        told = Stored(saved.state, str(source))
        moment = told.whole("number"), told.part("world").real("now")
        ours = saved.digest == run.scenario.digest and saved.extra.get("started") == run.manifest["started"]
        if ours and told.flag("running") and moment <= (episode, at):
            return loaded(Colony, source, saved, policy=policy, backend=backend)
    return anew(run.manifest, run.scenario, policy, backend, None, None, decisions=False)
