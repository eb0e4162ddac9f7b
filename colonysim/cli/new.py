"""`colonysim new`: write a scenario of a given kind and size."""

from __future__ import annotations

from typing import Annotated, Literal

import typer

from colonysim.cli.documents import OutOption

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim new platforms --columns 3 --rows 2 --agents 6 -o islands.yaml
  colonysim new grid --columns 100 --rows 100 --agents 1000 --holes 100 -o large.yaml
  colonysim new rooms --seed 7 | less
"""


def command(
    kind: Annotated[
        Literal["grid", "rooms", "platforms", "geometric"],
        typer.Argument(help="Level grid, rooms with doors, platforms whose doors are holes, or nodes at random."),
    ],
    columns: Annotated[int, typer.Option(min=1, help="Nodes along x; rooms or platforms along x.")] = 3,
    rows: Annotated[int, typer.Option(min=1, help="Nodes along y; rooms or platforms along y.")] = 3,
    size: Annotated[
        int | None, typer.Option(help="Nodes along each side of a room or platform.", show_default="6")
    ] = None,
    holes: Annotated[int, typer.Option(min=0, help="Holes; platforms have one at each door instead.")] = 0,
    spare: Annotated[int, typer.Option(min=0, help="Boxes besides those that the holes need.")] = 0,
    depth: Annotated[int | None, typer.Option(help="Boxes that fill a hole.", show_default="1")] = None,
    agents: Annotated[int, typer.Option(min=1, help="How many agents.")] = 4,
    crowded: Annotated[bool, typer.Option("--crowded", help="Start all agents in one corner.")] = False,
    seed: Annotated[int, typer.Option("--seed", "-s", min=0, help="Makes the world.")] = 0,
    out: OutOption = None,
) -> None:
    """Write a scenario of a given kind and size that can be solved.

    The place itself is generated from the seed whenever the file is read, so that the file stays small.
    """
    from colonysim.cli.documents import write_document
    from colonysim.scenario.invent import invent

    document = invent(
        kind, columns=columns, rows=rows, size=size, holes=holes, spare=spare, depth=depth, agents=agents,
        crowded=crowded, seed=seed,
    )  # fmt: skip
    write_document(document, out)
