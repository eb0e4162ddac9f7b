"""Robot colonies that coordinate through marks left in the place itself, on any backend.

Example:
    ```python
    import colonysim

    for event in colonysim.simulate(colonysim.load_scenario("hard"), seed=1):
        print(event.time, event.kind, event.agent, event.node)

    run = colonysim.run("hard", seed=1)  # the same, kept in a run directory
    print([episode.steps for episode in run.episodes], run.path)
    ```
"""

from __future__ import annotations

TYPE_CHECKING = False  # `typing` is what would take longest here, and Ctrl-C may come at once
if TYPE_CHECKING:
    from typing import Any

    from colonysim.errors import (
        ColonysimError,
        MissingExtraError,
        PluginError,
        ScenarioError,
        TraceError,
    )
    from colonysim.policies.schema import scenario_schema
    from colonysim.recording import run
    from colonysim.repeating import repeat
    from colonysim.resuming import resume
    from colonysim.scenario.imports import import_map
    from colonysim.scenario.loading import list_scenarios, load_scenario, scenario_from_document
    from colonysim.scenario.scenario import Scenario
    from colonysim.simulation import Colony, simulate
    from colonysim.trace.reader import Run
    from colonysim.trace.schema import EpisodeResult, Event

__version__ = "0.1.0"

__all__ = [
    "Colony",
    "ColonysimError",
    "EpisodeResult",
    "Event",
    "MissingExtraError",
    "PluginError",
    "Run",
    "Scenario",
    "ScenarioError",
    "TraceError",
    "__version__",
    "import_map",
    "list_scenarios",
    "load_scenario",
    "repeat",
    "resume",
    "run",
    "scenario_from_document",
    "scenario_schema",
    "simulate",
]

_PLACES = {
    "Colony": "simulation",
    "ColonysimError": "errors",
    "EpisodeResult": "trace.schema",
    "Event": "trace.schema",
    "MissingExtraError": "errors",
    "PluginError": "errors",
    "Run": "trace.reader",
    "Scenario": "scenario.scenario",
    "ScenarioError": "errors",
    "TraceError": "errors",
    "import_map": "scenario.imports",
    "list_scenarios": "scenario.loading",
    "load_scenario": "scenario.loading",
    "repeat": "repeating",
    "resume": "resuming",
    "run": "recording",
    "scenario_from_document": "scenario.loading",
    "scenario_schema": "policies.schema",
    "simulate": "simulation",
}


def __getattr__(name: str) -> Any:
    # Importing the package costs nothing: each name loads its module when it is first asked for.
    if name not in _PLACES:
        raise AttributeError(f"module 'colonysim' has no attribute {name!r}")
    from importlib import import_module

    value = globals()[name] = getattr(import_module(f"colonysim.{_PLACES[name]}"), name)
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
