"""How a colony was asked for, and what a saved one is made of again: no file makes code of others be imported."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

from colonysim.backends.nodeworld import NodeWorld
from colonysim.errors import ColonysimError, PluginError
from colonysim.geometry.robot_choice import of_others
from colonysim.plugins import PHYSICS, available, called
from colonysim.scenario.loading import load_scenario, scenario_from_document
from colonysim.scenario.scenario import Scenario
from colonysim.simulation.saving import Origin

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    from colonysim.backends.protocol import Backend
    from colonysim.policies.policy import Policy
    from colonysim.simulation.saving import Saved

__all__ = [
    "Origin", "backend_of", "importable", "known", "origin_of", "policy_of", "refuse_code_of_others",
    "refuse_executor_of_others", "scenario_of",
]  # fmt: skip


def origin_of(
    backend: str | Backend,
    options: Mapping[str, Any] | None,
    policy: str | Policy | Callable[[Scenario], Policy] | None,
) -> Origin:
    """How a colony is asked for with these arguments of its."""
    given: dict[str, Any] | None = dict(options or {})
    if isinstance(backend, str):
        body = backend
    else:
        kind: type = type(backend)
        body, given = called("backends", backend, backend), {} if kind is NodeWorld else None
    if policy is None or isinstance(policy, str):
        return Origin(body, given, policy)
    return Origin(body, given, called("policies", policy, policy), made=True)


def known(group: str, name: str) -> bool:
    """Whether a name is of this package, or of one that is installed under an entry point."""
    return ":" not in name and name in available(group)


def scenario_of(saved: Saved, path: Path, scenario: Scenario | str | Path | None) -> Scenario:
    """The scenario of a saved colony.

    Args:
        saved: The saved colony.
        path: Its file, for messages.
        scenario: The scenario that the caller gives, if any; it has to be the same.

    Raises:
        ColonysimError: It names code of others and was not given, or is another.
    """
    if scenario is not None:
        found = scenario if isinstance(scenario, Scenario) else load_scenario(scenario)
        if found.digest != saved.digest:
            raise ColonysimError(f"{path}: was made from another scenario than {found.name!r} ({found.digest[:12]})")
        return found
    if not saved.document:
        raise ColonysimError(f"{path}: holds no scenario, as it was made in Python; give it, scenario=")
    found = scenario_from_document(saved.document, source=f"{path}: scenario")
    if found.digest != saved.digest:
        raise ColonysimError(f"{path}: damaged: the scenario is not the one that its hash tells of")
    refuse_code_of_others(found, "scenario=")
    return found


def refuse_code_of_others(scenario: Scenario, way: str) -> None:
    """Refuses a scenario out of a file that would have fields, groups' policies or robots of others imported.

    Args:
        scenario: The scenario.
        way: What the caller can give to say that he wants that.

    Raises:
        PluginError: It would.
    """
    groups = scenario.parts_of_groups
    extra = [name for own in (scenario.parameters, *(own for _, own in groups)) for name in _named_fields(own)]
    others = [str(name) for name in extra if not known("fields", str(name))]
    others += [policy for policy, _ in groups if policy is not None and not known("policies", policy)]
    others += of_others(scenario)
    if others:
        raise PluginError(f"names code of others, which no file imports by itself: {', '.join(others)}; give {way}")


def _named_fields(parameters: Mapping[str, Any]) -> list[Any]:
    found = parameters.get("extra_fields") or ()
    return [found] if isinstance(found, str) else [*found]


def importable(kind: Literal["policy", "backend"], name: str) -> str:
    """A policy's or a backend's name out of a file, if the file may have it imported.

    Args:
        kind: Which of the two it names.
        name: As the saved colony or the run calls it.

    Raises:
        PluginError: It is code of others, which only whoever goes on with the colony may have imported.
    """
    if not known({"policy": "policies", "backend": "backends"}[kind], name):
        given = name if ":" in name else "package.module:Name"
        raise PluginError(
            f"its {kind} {name!r} is code of others, which no file imports by itself; name it again, "
            f"--{kind} {given}, from Python {kind}="
        )
    return name


def refuse_executor_of_others(options: Mapping[str, Any] | None) -> None:
    """Refuses options of a backend, out of a file, that would have a push executor of others imported.

    Raises:
        PluginError: They would.
    """
    push = (options or {}).get("push")
    if isinstance(push, str) and not known("executors", push):
        raise PluginError(
            f"its push executor {push!r} is code of others, which no file imports by itself; give the backend, made "
            f"with it: backend=..."
        )


def backend_of(
    saved: Saved, backend: str | Backend | None, options: Mapping[str, Any] | None
) -> tuple[str | Backend, Mapping[str, Any] | None]:
    """The backend for a saved colony, and its options.

    Raises:
        PluginError: It is code of others, or was an object, and is not given.
    """
    origin = saved.origin
    if backend is not None:
        same = isinstance(backend, str) and (backend == origin.backend or {backend, origin.backend} <= {*PHYSICS})
        return backend, origin.options if options is None and same else options
    if origin.options is None:
        raise PluginError(f"its backend {origin.backend!r} was given as an object; give another one, backend=")
    refuse_executor_of_others(origin.options if options is None else options)
    return importable("backend", origin.backend), origin.options if options is None else options


def policy_of(
    saved: Saved, policy: str | Policy | Callable[[Scenario], Policy] | None
) -> str | Policy | Callable[[Scenario], Policy] | None:
    """The policy for a saved colony; None for the scenario's own.

    Raises:
        PluginError: It is code of others, or was an object, and is not given.
    """
    if policy is not None:
        return policy
    name = saved.origin.policy
    if saved.origin.made:
        raise PluginError(f"its policy {name!r} was given as an object or a function; give it, policy=")
    own = saved.document.get("policy")
    asked = name if name is not None else own.get("name") if isinstance(own, dict) else own
    if isinstance(asked, str):
        importable("policy", asked)
    return name
