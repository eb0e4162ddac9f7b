"""Run directories of what was played in an environment."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from colonysim.plugins import called, make_backend, make_policy
from colonysim.provenance import parts_of
from colonysim.simulation import mode_of
from colonysim.trace.kept import by_size
from colonysim.trace.manifest import begin_manifest, prepare_directory
from colonysim.trace.writer import TraceWriter

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from colonysim.scenario.scenario import Scenario

__all__ = ["begin_run"]


def begin_run(
    directory: Path,
    scenario: Scenario,
    *,
    backend: str,
    backend_options: Mapping[str, Any] | None,
    policy: Any,
    mode: str | None,
    episodes: int,
    seed: int,
) -> TraceWriter:
    """The sink of a run whose decisions come from outside.

    Args:
        directory: Where it is written, absent or empty.
        scenario: The scenario.
        backend: Name of the backend.
        backend_options: Its options.
        policy: The policy whose marks the agents leave, as for a colony.
        mode: The mode; the scenario's own if None.
        episodes: How many there will be.
        seed: The run's seed.

    Raises:
        ColonysimError: The directory cannot be written.
    """
    kept, body = by_size(scenario, episodes), make_backend(backend, backend_options, scenario)
    given = scenario.policy if policy is None else policy
    try:
        manifest = begin_manifest(
            scenario.name, scenario=scenario, backend=called("backends", backend, body), mode=mode_of(scenario, mode),
            policy=f"outside-{called('policies', given, make_policy(policy, scenario))}", episodes=episodes, seed=seed,
            variant=scenario.variant, recorded=kept.document(), engine=getattr(body, "engine", None),
            options={
                "backend": dict(backend_options or {}), "overrides": scenario.settings,
                "decisions": "decisions" in kept.tables, "initial": None,
            },
        )  # fmt: skip
    finally:
        body.close()
    manifest["sources"] = parts_of(given, manifest["backend"], scenario.parameters, backend_options)
    return TraceWriter(prepare_directory(directory, manifest), manifest, drop=kept.dropped)
