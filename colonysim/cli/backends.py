"""`colonysim backends`: what can move the robots, what can decide for them, and what they can leave behind."""

from __future__ import annotations

from typing import Annotated, Any

import typer

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim backends
  colonysim backends --json
"""


_GROUPS = ("backends", "policies", "fields", "executors", "robots")


def command(as_json: Annotated[bool, typer.Option("--json", help="Print the list as JSON.")] = False) -> None:
    """List backends, policies, pheromone fields, push executors and robots, plugins included.

    Also says what keeps one from being used, and which versions of the rigid-body engines are installed.

    A plugin announces itself under the entry-point group colonysim.backends,
    colonysim.policies, colonysim.fields, colonysim.executors or colonysim.robots; a field
    is carried along by policy.extra_fields, an executor is chosen by `run --push`, a robot
    by physics.robot. The fields D, E, H and B are there with every stigmergic policy.
    """
    from colonysim.built import build
    from colonysim.cli.console import print_json, print_table
    from colonysim.plugins import available

    found: list[dict[str, str]] = []
    for group in _GROUPS:
        if group == "fields":
            found += [{"kind": group, **own} for own in _own_fields()]
        for name, place in sorted(available(group).items()):
            found.append({"kind": group, "name": name, "place": place, **_look(group, name)})
    if as_json:
        print_json(found)
        return
    print_table(("build", ""), [("colonysim", build())])
    for group in _GROUPS:
        print_table((group, ""), [(each["name"], _told(each)) for each in found if each["kind"] == group])


def _told(each: dict[str, str]) -> str:
    """What the table says of a part: what keeps it from being used, or what it is, with its engine's version."""
    version = f" ({each['version']})" if each["version"] else ""
    return each["problem"] or f"{each['summary']}{version}"


def _own_fields() -> list[dict[str, str]]:
    """The fields that the stigmergic policies have in any case."""
    from colonysim.pheromones import BoxWorth, Distance, Exploration, HoleTrail

    return [
        {
            "name": field.name,
            "place": f"{field.__module__}:{field.__name__}",
            "summary": _summary(field),
            "version": "",
            "problem": "",
        }
        for field in (Distance, Exploration, HoleTrail, BoxWorth)
    ]


def _sizes(robot: Any) -> str:
    """A robot in a few numbers."""
    return (
        f"{robot.length:g} m long, {robot.width:g} m wide, {robot.mass:g} kg, with wheels of {robot.wheel_radius:g} m"
        f" that turn at up to {robot.wheel_speed:.3g} rad/s"
    )


def _summary(thing: Any) -> str:
    return (thing.__doc__ or "").strip().partition("\n")[0]


def _look(group: str, name: str) -> dict[str, str]:
    """The first line of its docstring, the version of the engine below it, and what keeps it from being used."""
    from colonysim.cli.extras import need_engine
    from colonysim.errors import ColonysimError
    from colonysim.physics import engine_version
    from colonysim.plugins import PHYSICS, load

    version = ""
    try:
        if group == "backends" and name in PHYSICS:
            version = engine_version(need_engine(None if name == "physics" else name))
        found = load(group, name)
        summary = _sizes(found) if group == "robots" else _summary(found)
        return {"summary": summary, "version": version, "problem": ""}
    except ColonysimError as error:
        return {"summary": "", "version": version, "problem": str(error)}
