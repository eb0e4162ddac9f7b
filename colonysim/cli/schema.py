"""`colonysim schema`: the scenario format as JSON Schema."""

from __future__ import annotations

from typing import Annotated, Literal

import typer

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim schema > scenario.schema.json
  colonysim schema trace
"""


def command(
    what: Annotated[
        Literal["scenario", "trace"], typer.Argument(help="The scenario format, or the tables of a run.")
    ] = "scenario",
) -> None:
    """Print the scenario format as JSON Schema, or a run's tables.

    With the schema an editor completes, explains and checks scenarios as you type, the parameters of this
    package's policies too; those of others are for the run to check.
    """
    from colonysim.cli.console import print_json

    if what == "trace":
        from colonysim.trace.schema import TABLES, VERSION

        print_json({"version": VERSION, "tables": TABLES})
    else:
        from colonysim.policies.schema import scenario_schema

        print_json(scenario_schema())
