"""`colonysim plot`: draw a run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from colonysim.files import shown_path

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim plot runs/hard-nodeworld-s0-1
  colonysim plot runs/hard-nodeworld-s0-1 --what H,B --hole 29 --box 3 --episodes 1,3,10 -f pdf
  colonysim plot runs/scouts-nodeworld-s0-1 --what episodes,waiting --by-group
  colonysim plot runs/pushes --what trajectories
  colonysim plot models/mine
"""


def command(
    path: Annotated[
        Path, typer.Argument(metavar="RUN", help="A run directory, or the directory of a training.", show_default=False)
    ],
    what: Annotated[
        str | None,
        typer.Option(
            "--what",
            "-w",
            help="Comma-separated: D, E, H, B, map, trajectories, episodes, waiting, workload, fates; of single pushes "
            "trajectories, samples.",
            show_default="all",
        ),
    ] = None,
    episodes: Annotated[
        str | None, typer.Option("--episodes", help="Which, such as 1,3,10.", show_default="first, some between, last")
    ] = None,
    hole: Annotated[
        int | None, typer.Option("--hole", help="Node of the hole whose H is drawn.", show_default="all of them")
    ] = None,
    box: Annotated[
        int | None, typer.Option("--box", help="Box whose B is drawn.", show_default="the first six")
    ] = None,
    by_group: Annotated[
        bool, typer.Option("--by-group", help="An image of episodes, waiting and workload for each group of agents.")
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", "-o", metavar="DIR", help="Where to put the images.", show_default="plots/ in the run directory"
        ),
    ] = None,
    kind: Annotated[Literal["png", "svg", "pdf"], typer.Option("--format", "-f", help="File format.")] = "png",
) -> None:
    """Draw a run: pheromones, map, trajectories, results, waiting, workload, boxes.

    D distance, E exploration, H of a hole, B of a box: a panel an
    episode, as at its end. map shows boxes, holes, agents and blocked edges (red slashes) at the start
    and the end, trajectories the ways of agents (pink) and boxes (blue), episodes steps and
    success by episode, waiting what agents did over an episode's time and how long they waited in
    each, workload the steps of each agent and how evenly they are shared (Gini coefficient),
    fates where each box ended and how often. Of single pushes (`colonysim evaluate push --out`) there are
    trajectories, a panel a terrain, and samples, a panel a push; of a training (`colonysim
    train push`) its learning curve, of a fit (`colonysim train way`) its calibration.
    """
    from colonysim.cli.console import print_result
    from colonysim.cli.extras import need
    from colonysim.cli.numbers import read_numbers
    from colonysim.cli.opening import opened

    need("matplotlib", "plot", "drawing")
    from colonysim.errors import ColonysimError
    from colonysim.plots import draw, draw_training, is_training

    wanted = None
    if what is not None:
        wanted = tuple(dict.fromkeys(word.strip() for word in what.split(",") if word.strip()))
    chosen = None if episodes is None else read_numbers(episodes)
    if is_training(path):
        if what not in (None, "learning") or episodes is not None or hole is not None or box is not None or by_group:
            raise ColonysimError(f"{path}: a training, of which there is one image only; leave the choice out")
        images = draw_training(path, out=out, kind=kind)
    else:
        run = opened(path) if what else opened(path, "frames", "poses")
        images = draw(run, what=wanted, episodes=chosen, hole=hole, box=box, by_group=by_group, out=out, kind=kind)
    for image in images:
        print_result(shown_path(image))
