"""One trial, wherever it runs: from its description to what the tables hold of it."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from colonysim.errors import ColonysimError
from colonysim.geometry.robot_choice import with_robot
from colonysim.provenance import TAG, parts_of, telling
from colonysim.recording import groups_at_end, run
from colonysim.scenario.loading import load_scenario
from colonysim.simulation import Colony
from colonysim.simulation.adopting import diverge
from colonysim.simulation.keeping import loaded
from colonysim.simulation.saving import read_saved
from colonysim.sweep.plan import found
from colonysim.sweep.tables import STATE
from colonysim.trace.writer import TraceWriter

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from colonysim.provenance import Sources
    from colonysim.scenario.scenario import Scenario
    from colonysim.sweep.plan import Trial
    from colonysim.trace.groups import GroupResult
    from colonysim.trace.schema import EpisodeResult

__all__ = ["run_trial"]


def run_trial(trial: Trial) -> dict[str, Any]:
    """Runs a trial without recording it.

    Returns:
        `trace_sha256` and `episodes`: for each its number, steps, success, ended, sim_seconds and seated; and of a
        scenario with groups `groups`: for each episode and group what a `GroupResult` holds. If scenario
        or code are no longer those that the trial was planned with, nothing is run, and `changed` names them.
    """
    if trial.start:
        return _future(trial)
    scenario = _loaded(trial.scenario, trial.folder, trial.variant, json.dumps(trial.parameters))
    if changed := _changed(trial, scenario):
        return {"changed": changed}
    recorded = run(
        scenario, backend=trial.backend, backend_options=trial.options, policy=trial.policy, mode=trial.mode,
        episodes=trial.episodes, seed=trial.seed, trace=False,
    )  # fmt: skip
    return _result(recorded.trace_sha256, recorded.episodes, recorded.groups)


def _future(trial: Trial) -> dict[str, Any]:
    """Plays a trial that begins at a saved moment."""
    path = Path(trial.folder) / STATE
    saved = replace(read_saved(path), episodes=trial.episodes or 0)
    if saved.extra != trial.start:
        raise ColonysimError(f"{path}: is the colony of another moment")
    writer = TraceWriter(None, {})
    mind, mover = trial.given.get("policy"), trial.given.get("backend")
    groups: list[GroupResult] = []
    with writer, loaded(
        Colony, path, saved, policy=mind, backend=mover, sink=writer, kinds=("episode",)
    ) as colony:  # fmt: skip
        diverge(colony, trial.seed, trial.parameters)
        for event in colony:
            groups += groups_at_end(colony, event.episode)
    return _result(writer.manifest["trace_sha256"], writer.results, groups)


def _result(digest: str | None, episodes: Iterable[EpisodeResult], groups: Iterable[GroupResult]) -> dict[str, Any]:
    """What `run_trial` returns."""
    told = [list(group) for group in groups]
    return {**({"groups": told} if told else {}), "trace_sha256": digest, "episodes": _rows(episodes)}


def _rows(episodes: Iterable[EpisodeResult]) -> list[list[Any]]:
    return [[e.episode, e.steps, e.success, e.ended, e.sim_seconds, e.seated] for e in episodes]


def _changed(trial: Trial, scenario: Scenario) -> str:
    if scenario.digest != trial.digest:
        return f"scenario {trial.scenario}"
    found = _sources(
        trial.policy or scenario.policy, trial.backend, json.dumps(telling(scenario.parameters)),
        json.dumps(trial.options), json.dumps(scenario.parts_of_groups),
    )  # fmt: skip
    planned, there = _flat(trial.sources), _flat(found)
    return ", ".join(f"{m} ({part})" for part, m in planned | there if planned.get((part, m)) != there.get((part, m)))


def _flat(sources: Mapping[str, Mapping[str, str]]) -> dict[tuple[str, str], str]:
    return {(part, m): value for part, modules in sources.items() for m, value in modules.items() if m != TAG}


@lru_cache(maxsize=64)
def _sources(policy: str, backend: str, parameters: str, options: str, groups: str) -> Sources:
    """As they were when this process first needed them: it keeps to what it has imported."""
    return parts_of(policy, backend, json.loads(parameters), json.loads(options), json.loads(groups))


@lru_cache(maxsize=8)
def _loaded(scenario: str, folder: str, variant: str | None, parameters: str) -> Scenario:
    """Trials that differ by their seed follow each other; reading the file would take longer than a short one."""
    return with_robot(load_scenario(found(scenario, folder), variant, json.loads(parameters)))
