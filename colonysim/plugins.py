"""Finding policies, fields, backends, push executors and robots by name, by entry point or as "package.module:Name"."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from functools import partial
from importlib.metadata import entry_points
from typing import TYPE_CHECKING, Any, cast

from colonysim.engines import PACKAGES
from colonysim.errors import PASSED_ON, ColonysimError, PluginError, told
from colonysim.suggest import nearest

if TYPE_CHECKING:
    from colonysim.backends.protocol import Backend
    from colonysim.pheromones.field import Field
    from colonysim.policies.policy import Policy
    from colonysim.scenario.scenario import Scenario
    from colonysim.world.state import World

__all__ = [
    "BUILT_IN",
    "PHYSICS",
    "available",
    "called",
    "lacking",
    "load",
    "locate",
    "make_backend",
    "make_field",
    "make_policy",
    "refuse_other_engine",
]

BUILT_IN: dict[str, dict[str, str]] = {
    "backends": {
        "nodeworld": "colonysim.backends.nodeworld:NodeWorld",
        "bullet": "colonysim.backends.bullet:Bullet",
        "mujoco": "colonysim.backends.mujoco:Mujoco",
        "physics": "colonysim.backends.physics:Physics",
        "mock": "colonysim.backends.mock:Mock",
    },
    "policies": {
        "stigmergy": "colonysim.policies.stigmergy:Stigmergy",
        "colony": "colonysim.policies.presets:Colony",
        "paper": "colonysim.policies.presets:Paper",
        "oracle": "colonysim.policies.presets:Oracle",
        "random": "colonysim.policies.uniform:Uniform",
        "learned": "colonysim.rl.learned:Learned",
    },
    "fields": {},
    "executors": {
        "rl": "colonysim.push.executors:Rl",
        "staged": "colonysim.push.executors:Staged",
        "scripted": "colonysim.push.executors:Scripted",
    },
    "robots": {"standard": "colonysim.physics.robot:STANDARD", "half": "colonysim.physics.robot:HALF"},
}
PHYSICS = ("physics", *PACKAGES)
"""The backends of rigid bodies: of the engine that the scenario names, and of one engine each."""

PROTOCOLS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "backends": (
        ("reset", "feasible", "footprint", "start", "advance", "cancel", "leave", "rows", "close"),
        ("tick", "edge_seconds"),
    ),
    "policies": (("fields", "begin", "decide"), ()),
    "fields": (("at", "keys", "deposit", "end_episode", "frame", "load"), ("by_box",)),
}
"""The methods and attributes of each protocol, besides a name."""


def available(group: str) -> dict[str, str]:
    """Names and "module:Name" of everything in a group: our own and what is installed under `colonysim.<group>`.

    Args:
        group: "backends", "policies", "fields", "executors" or "robots".
    """
    found = {point.name: point.value for point in entry_points(group=f"colonysim.{group}")}
    return {**found, **BUILT_IN[group]}


def locate(group: str, name: str) -> str:
    """The "package.module:Name" of what is called `name` in a group; nothing is imported.

    Raises:
        PluginError: There is no such name; the nearest one is named.
    """
    # Looking through what is installed takes milliseconds, and nothing there goes before our own.
    place = name if ":" in name else BUILT_IN[group].get(name) or available(group).get(name)
    if place is None:
        names = sorted(available(group))
        hint = nearest(name, names)
        own = "" if hint.startswith("did") else "; one of your own is 'module:Name'"
        raise PluginError(f"no {_kind(group)} {name!r}; {hint}{own}")
    return place


def load(group: str, name: str) -> Any:
    """The class or factory called `name` in a group, or at "package.module:Name".

    Raises:
        PluginError: There is no such name (the nearest one is named), or its module cannot be imported.
    """
    place = locate(group, name)
    module, _, attribute = place.partition(":")
    try:
        found: Any = importlib.import_module(module)
        for part in attribute.split("."):
            found = getattr(found, part)
    except PASSED_ON:
        raise
    except BaseException as error:  # another's module may fail in any way, exit() included; ours still owes a message
        absent = isinstance(error, ModuleNotFoundError) and module.startswith(error.name or module)
        hint = "; Python does not find it: install it, or name its folder in PYTHONPATH" if absent else ""
        raise PluginError(f"{name!r} ({place}) cannot be loaded: {told(error)}{hint}") from error
    return found


def called(group: str, given: Any, part: Any) -> str:
    """The one name by which tables and comparisons know a part, however it was asked for.

    Of ours it is the name under which they are listed, of the stigmergic policy that of its preset. Of others it is the
    name that the part or its very class says, if none of ours has it: one that is inherited is another class's. What
    says none has the name under which it is installed, or is known by its "module:Name".

    Args:
        group: "backends", "policies" or "fields".
        given: What was asked for: a name, a class, a function, or the part itself.
        part: What was made of it, or the class that will make it.

    Example:
        >>> called("backends", "colonysim.backends.mock:Mock", load("backends", "mock"))
        'mock'
    """
    kind = part if isinstance(part, type) else type(part)
    place = f"{kind.__module__}:{kind.__qualname__}"
    while isinstance(given, partial):
        given = given.func
    if isinstance(given, str):
        asked = locate(group, given)
    else:
        made_by = given if hasattr(given, "__qualname__") else type(given)
        asked = f"{made_by.__module__}:{made_by.__qualname__}"
    if "<" in asked:  # a function that has no name elsewhere
        asked = place
    ours = {where: name for name, where in BUILT_IN[group].items()}
    says = getattr(part, "name", None)
    if asked == place and place in ours:
        return says if says in BUILT_IN[group] else ours[place]
    of_class = vars(kind).get("name")
    itself = "name" in getattr(part, "__dict__", ()) or not (of_class is None or isinstance(of_class, str))
    for name in (says if itself else None, of_class):
        if isinstance(name, str) and name and name not in BUILT_IN[group]:
            return name
    return next((each for each, where in available(group).items() if where == asked), asked)


def lacking(group: str, part: object) -> str:
    """What keeps an object from being a backend, a policy or a field, in words; "" if nothing does."""
    methods, attributes = PROTOCOLS[group]
    kind = _kind(group)
    if part is None:
        return f"is None, expected a {kind}"
    if isinstance(part, type):
        return f"is the class {part.__name__}, expected a {kind} made from it"
    for name in methods:
        if not callable(getattr(part, name, None)):
            return f"is no {kind}: {type(part).__name__} has no method {name!r}"
    for name in attributes:
        if not hasattr(part, name):
            return f"is no {kind}: {type(part).__name__} has no attribute {name!r}"
    try:
        called = getattr(part, "name", None)
    except Exception as error:
        return f"is no {kind}: the name of {type(part).__name__} raises {told(error)}"
    if not (isinstance(called, str) and called):
        return f"is no {kind}: the name of {type(part).__name__} is {called!r}, expected some text"
    return ""


def _kind(group: str) -> str:
    return {"policies": "policy", "executors": "push executor"}.get(group, group[:-1])


def _made(group: str, what: str, factory: Callable[..., Any], *arguments: Any) -> Any:
    """What a factory makes.

    Raises:
        PluginError: It fails, or makes something that is no such part.
    """
    try:
        part = factory(*arguments)
    except PASSED_ON:
        raise
    except BaseException as error:  # another's code may fail in any way, exit() included; ours still owes a message
        raise PluginError(f"{what} cannot be made: {told(error)}") from error
    return _complete(group, what, part)


def _complete(group: str, what: str, part: Any) -> Any:
    if missing := lacking(group, part):
        raise PluginError(f"{what} {missing}")
    return part


def make_field(name: str, world: World) -> Field:
    """The pheromone field called `name`, built for a world.

    Raises:
        PluginError: There is no such field, or it is none.
    """
    return cast("Field", _made("fields", f"field {name!r}", load("fields", name), world))


def make_backend(
    name: str | Backend, options: Mapping[str, Any] | None = None, scenario: Scenario | None = None
) -> Backend:
    """The backend called `name`, built with its options; a backend itself is handed back.

    Args:
        name: Its name, or a backend. "physics" is the engine that the scenario names, by default the first installed.
        options: Keyword arguments for a backend given by name.
        scenario: What it will run; `physics.engine` is read from it.

    Raises:
        ScenarioError: The scenario names another engine than `name`.
        PluginError: There is no such backend, or what was found is none.
        ColonysimError: It does not know one of the options, or a backend is given that is made already.
        MissingExtraError: It needs a package that is not installed.
    """
    if not isinstance(name, str):
        if options:
            raise ColonysimError(f"backend options {', '.join(options)}: only with a backend given by its name")
        body = _complete("backends", "what was given as backend", name)
    else:
        wanted = {"engine": scenario.physics.get("engine")} if name == "physics" and scenario is not None else {}
        asked, factory = {**wanted, **(options or {})}, load("backends", name)

        def made() -> Any:
            try:
                return factory(**asked)
            except TypeError as error:
                raise ColonysimError(f"backend {name!r} does not take these options: {error}") from None

        body = _made("backends", f"backend {name!r}", made)
    if scenario is not None:
        refuse_other_engine(scenario, getattr(getattr(body, "engine", None), "name", None))
    return cast("Backend", body)


def refuse_other_engine(scenario: Scenario, engine: str | None) -> None:
    """Refuses a backend on another engine than the one that a scenario asks for.

    Args:
        scenario: The scenario; `physics.engine` is read from it.
        engine: The engine of the backend; None if it has none.

    Raises:
        ScenarioError: They differ.
    """
    wanted = scenario.physics.get("engine")
    if wanted is not None and engine is not None and wanted != engine:
        raise scenario.fault("physics.engine", f"{wanted!r} contradicts the backend, which runs on {engine!r}")


def make_policy(policy: str | Policy | Callable[[Scenario], Policy] | None, scenario: Scenario) -> Policy:
    """The policy called `policy` (or the scenario's own), built for `scenario`; a policy itself is handed back.

    Raises:
        PluginError: There is no such policy, or what was found is none.
        ScenarioError: The scenario's parameters do not fit it.
    """
    if policy is None:
        policy = scenario.policy
    what = f"policy {policy!r}" if isinstance(policy, str) else "what was given as policy"
    if isinstance(policy, str):
        policy = load("policies", policy)
    built = _made("policies", what, policy, scenario) if callable(policy) else _complete("policies", what, policy)
    return cast("Policy", built)
