"""`colonysim backends`: what can move the robots, and what can decide for them."""

from __future__ import annotations

from typing import Annotated

import typer

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim backends
"""


def command(as_json: Annotated[bool, typer.Option("--json", help="Print the list as JSON.")] = False) -> None:
    """List backends and policies, plugins included.

    Also says what keeps one from being used.

    A plugin announces itself under the entry-point group colonysim.backends or
    colonysim.policies.
    """
    from colonysim.cli.console import print_json, print_table
    from colonysim.plugins import available

    found = []
    for group in ("backends", "policies"):
        for name, place in sorted(available(group).items()):
            summary, problem = _look(group, name)
            found.append({"kind": group, "name": name, "place": place, "summary": summary, "problem": problem})
    if as_json:
        print_json(found)
        return
    for group in ("backends", "policies"):
        rows = [(each["name"], each["problem"] or each["summary"]) for each in found if each["kind"] == group]
        print_table((group, ""), [(str(name), str(text)) for name, text in rows])


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
    return (found.__doc__ or "").strip().partition("\n")[0], ""
