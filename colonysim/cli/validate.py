"""`colonysim validate`: check scenario files without running them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from colonysim.world.scenario import Scenario

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim validate my.yaml
  colonysim validate scenarios/*.yaml
  colonysim validate my.yaml --set policy.beta=2
"""


def command(
    scenarios: Annotated[list[str], typer.Argument(help="Scenario files, or names of scenarios.", show_default=False)],
    variant: Annotated[
        str | None, typer.Option("--variant", "-v", help="Only this variant. [default: all of them]")
    ] = None,
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Set a field first; may be given again.")
    ] = None,
) -> None:
    """Check scenario files without running them.

    Each of their variants and the policy's parameters are checked too.

    A fault is told as file:line:column: field: what is wrong; the exit code is then 2.
    """
    from colonysim.cli.console import say
    from colonysim.errors import ColonysimError

    faults = 0
    for name in scenarios:
        try:
            _check(name, variant, settings or [])
        except ColonysimError as error:
            say(f"Error: {error}")
            faults += 1
    if faults:
        raise SystemExit(2)


def _check(name: str, variant: str | None, settings: list[str]) -> None:
    from colonysim.plugins import make_policy
    from colonysim.world.loading import load_scenario, load_variants

    one_only = ((variant, load_scenario(name, variant, settings)),) if variant is not None else ()
    for one, scenario in one_only or load_variants(name, settings):
        make_policy(None, scenario)
        label = name if one is None else f"{name} (variant {one})"
        typer.echo(f"{label}: valid: {_outline(scenario)}")


def _outline(scenario: Scenario) -> str:
    counts = [
        (len(scenario.topology), "node"), (scenario.topology.edge_count, "edge"), (len(scenario.holes), "hole"),
        (len(scenario.boxes), "box"), (len(scenario.agents), "agent"),
    ]  # fmt: skip
    plural = {"box": "boxes"}
    return ", ".join(f"{n} {word if n == 1 else plural.get(word, word + 's')}" for n, word in counts)
