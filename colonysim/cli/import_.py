"""`colonysim import`: turn a map of another program into a scenario."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Literal

import typer

from colonysim.cli.documents import OutOption
from colonysim.cli.numbers import read_row
from colonysim.errors import ColonysimError

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim import arena.map --agents 20 --seed 1 -o arena.yaml
  colonysim import Berlin_0_512.map --diagonals --crop 100,100,299,299 --goal 250,120 -o berlin.yaml
  colonysim import microban.xsb --level 12 -o level.yaml
  colonysim import plan.png --colours '#c0c0c0=floor,#804000=wall' --tolerance 8 -o plan.yaml
  colonysim import warehouse.tmj | less
"""


def command(
    path: Annotated[
        Path,
        typer.Argument(
            metavar="FILE", help="MovingAI .map, Sokoban .xsb or .sok, picture .png, Tiled .tmj or .json.",
            show_default=False,
        ),
    ],
    out: OutOption = None,
    format: Annotated[
        Literal["movingai", "sokoban", "png", "tiled"] | None,
        typer.Option("--format", help="What the file is. [default: as its ending says]"),
    ] = None,
    agents: Annotated[
        str | None,
        typer.Option(
            metavar="N|X,Y ...", help="How many in all, or where besides the map's own: '2,3 4,5'.",
            show_default="those of the map, or 4 where it has none",
        ),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", "-s", min=0, help="Draws the start of those the map lacks.")] = 0,
    goal: Annotated[
        str | None,
        typer.Option(metavar="X,Y", help="Column and row of the goal. [default: the map's, or the farthest]"),
    ] = None,
    crop: Annotated[
        str | None, typer.Option(metavar="X0,Y0,X1,Y1", help="Keep only these columns and rows, both ends included.")
    ] = None,
    spacing: Annotated[float, typer.Option(help="Distance of neighbours, graph units.")] = 1.0,
    diagonals: Annotated[bool, typer.Option("--diagonals", help="Eight neighbours instead of four.")] = False,
    level: Annotated[int | None, typer.Option(help="Sokoban: which level. [default: 1]")] = None,
    floor: Annotated[str | None, typer.Option(help="MovingAI: characters that are floor.", show_default=".GS")] = None,
    colours: Annotated[
        str | None, typer.Option(metavar="COLOUR=KIND,...", help="Pictures: what more colours mean: #c0c0c0=floor.")
    ] = None,
    tolerance: Annotated[
        int | None, typer.Option(help="Pictures: how much a colour may differ, of 255.", show_default="0")
    ] = None,
) -> None:
    """Write a map of another program as a scenario.

    Squares of floor become nodes. Columns and rows are counted from 0, from the upper left corner of the file.
    """
    from colonysim.cli.documents import write_document
    from colonysim.scenario.imports import import_map

    borders = None if crop is None else read_row("--crop", crop, "X0,Y0,X1,Y1")
    target = None if goal is None else read_row("--goal", goal, "X,Y")
    document = import_map(
        path, format=format, level=level, floor=floor, colours=None if colours is None else _colours(colours),
        tolerance=tolerance, crop=borders, spacing=spacing, diagonals=diagonals,
        agents=None if agents is None else _agents(agents), goal=target, seed=seed,
    )  # fmt: skip
    write_document(document, out)


def _agents(text: str) -> int | list[tuple[int, ...]]:
    if re.fullmatch(r"\s*[0-9]{1,9}\s*", text):
        return int(text)
    return [read_row("--agents", part, "X,Y") for part in text.split()]


def _colours(text: str) -> dict[str, str]:
    found: dict[str, str] = {}
    for part in text.split(","):
        colour, equals, kind = (each.strip() for each in part.partition("="))
        if not equals:
            raise ColonysimError(f"--colours {part[:40]}: expected COLOUR=KIND, such as #c0c0c0=floor")
        found[colour] = kind
    return found
