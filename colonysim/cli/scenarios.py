"""`colonysim scenarios`: list the scenarios that come with the package, or print one."""

from __future__ import annotations

from typing import Annotated

import typer

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim scenarios
  colonysim scenarios hard > mine.yaml
"""


def command(
    name: Annotated[str | None, typer.Argument(help="Print this scenario's file.", show_default=False)] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the list as JSON.")] = False,
) -> None:
    """List the scenarios that come with colonysim, or print one."""
    from colonysim.cli.console import print_json, print_table, print_text
    from colonysim.errors import ScenarioError
    from colonysim.scenario.loading import list_scenarios
    from colonysim.suggest import nearest

    listed = list_scenarios()
    if name is not None:
        if as_json:
            raise ScenarioError("--json: of the list only; a scenario is printed as its file stands")
        found = {each: path for each, path, _, _ in listed}
        if name not in found:
            raise ScenarioError(f"no scenario {name!r}; {nearest(name, found)}")
        print_text(found[name].read_text(encoding="utf-8"))
    elif as_json:
        print_json([{"name": n, "path": str(p), "description": d, "variants": list(v)} for n, p, d, v in listed])
    else:
        rows = [(each, description, ", ".join(variants)) for each, _, description, variants in listed]
        print_table(("name", "description", "variants"), rows)
