"""`colonysim backends`: what can move the robots, what can decide for them, and what they can leave behind."""

from __future__ import annotations

from typing import Annotated, Any

import typer

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim backends
"""


_GROUPS = ("backends", "policies", "fields")


def command(as_json: Annotated[bool, typer.Option("--json", help="Print the list as JSON.")] = False) -> None:
    """List backends, policies and pheromone fields, plugins included.

    Also says what keeps one from being used.

    A plugin announces itself under the entry-point group colonysim.backends,
    colonysim.policies or colonysim.fields; a field is carried along by policy.extra_fields. The fields D, E, H and B
    are there with every stigmergic policy.
    """
    from colonysim.built import build
    from colonysim.cli.console import print_json, print_table
    from colonysim.plugins import available

    found = []
    for group in _GROUPS:
        if group == "fields":
            found += [{"kind": group, **own} for own in _own_fields()]
        for name, place in sorted(available(group).items()):
            summary, problem = _look(group, name)
            found.append({"kind": group, "name": name, "place": place, "summary": summary, "problem": problem})
    if as_json:
        print_json(found)
        return
    print_table(("build", ""), [("colonysim", build())])
    for group in _GROUPS:
        rows = [(each["name"], each["problem"] or each["summary"]) for each in found if each["kind"] == group]
        print_table((group, ""), [(str(name), str(text)) for name, text in rows])


def _own_fields() -> list[dict[str, str]]:
    """The fields that the stigmergic policies have in any case."""
    from colonysim.pheromones import BoxWorth, Distance, Exploration, HoleTrail

    return [
        {
            "name": field.name,
            "place": f"{field.__module__}:{field.__name__}",
            "summary": _summary(field),
            "problem": "",
        }
        for field in (Distance, Exploration, HoleTrail, BoxWorth)
    ]


def _summary(thing: Any) -> str:
    return (thing.__doc__ or "").strip().partition("\n")[0]


def _look(group: str, name: str) -> tuple[str, str]:
    """The first line of its docstring, and what keeps it from being used."""
    from colonysim.cli.extras import need_bullet
    from colonysim.errors import ColonysimError
    from colonysim.plugins import load

    try:
        if (group, name) == ("backends", "bullet"):
            need_bullet()
        found = load(group, name)
    except ColonysimError as error:
        return "", str(error)
    return _summary(found), ""
