"""One trial, wherever it runs: from its description to what the tables hold of it."""

from __future__ import annotations

import json
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from colonysim.recording import run
from colonysim.sweep.plan import found
from colonysim.world.loading import load_scenario

if TYPE_CHECKING:
    from colonysim.sweep.plan import Trial
    from colonysim.world.scenario import Scenario

__all__ = ["run_trial"]


def run_trial(trial: Trial) -> dict[str, Any]:
    """Runs a trial without recording it.

    Returns:
        `trace_sha256` and `episodes`: for each its number, steps, success, ended, sim_seconds and seated.
    """
    scenario = _loaded(trial.scenario, trial.folder, trial.variant, json.dumps(trial.parameters))
    recorded = run(
        scenario, backend=trial.backend, backend_options=trial.options, policy=trial.policy, mode=trial.mode,
        episodes=trial.episodes, seed=trial.seed, trace=False,
    )  # fmt: skip
    return {
        "trace_sha256": recorded.trace_sha256,
        "episodes": [
            [e.episode, e.steps, e.success, e.ended, e.sim_seconds, e.seated] for e in recorded.episodes
        ],
    }


@lru_cache(maxsize=8)
def _loaded(scenario: str, folder: str, variant: str | None, parameters: str) -> Scenario:
    """Trials that differ by their seed follow each other; reading the file would take longer than a short one."""
    return load_scenario(found(scenario, folder), variant, json.loads(parameters))
