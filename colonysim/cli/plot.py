"""`colonysim plot`: draw a run, a sweep, several runs or a training."""

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
  colonysim plot results/beta --x policy.beta --by policy --y steps --style paper --width 86mm -f pdf
  colonysim plot runs/hard-nodeworld-s0-1 runs/hard-nodeworld-s1-1
  colonysim plot runs/scouts-nodeworld-s0-1 --what episodes,waiting --by-group
  colonysim plot runs/pushes --what trajectories
  colonysim plot models/mine
"""


def command(
    paths: Annotated[
        list[Path],
        typer.Argument(metavar="DIR...", help="A run, sweeps and runs, or a training.", show_default=False),
    ],
    what: Annotated[
        str | None,
        typer.Option(
            "--what",
            "-w",
            help="Comma-separated: D, E, H, B, map, trajectories, episodes, waiting, workload, fates; of single pushes "
            "trajectories, samples; of sweeps and several runs means, heatmap, curves, differences.",
            show_default="all",
        ),
    ] = None,
    episodes: Annotated[
        str | None,
        typer.Option(
            "--episodes",
            help="Which, such as 1,3,10; of sweeps and several runs FIRST-LAST.",
            show_default="first, some between, last; all",
        ),
    ] = None,
    hole: Annotated[
        int | None, typer.Option("--hole", help="Node of the hole whose H is drawn.", show_default="all of them")
    ] = None,
    box: Annotated[
        int | None, typer.Option("--box", help="Box whose B is drawn.", show_default="the first six")
    ] = None,
    x: Annotated[
        str | None,
        typer.Option("--x", metavar="PARAM", help="Column of a sweep along the axis.", show_default="what varies most"),
    ] = None,
    by: Annotated[
        list[str] | None,
        typer.Option(
            "--by", metavar="PARAM", help="Column that is told apart by lines; may be given again.",
            show_default="what varies besides",
        ),
    ] = None,
    y: Annotated[
        Literal["success", "steps"] | None, typer.Option("--y", help="What is drawn of it.", show_default="both")
    ] = None,
    style: Annotated[
        Literal["screen", "paper"],
        typer.Option("--style", help="paper: of a given width, without title, thin lines, fonts of type 42."),
    ] = "screen",
    width: Annotated[
        str | None,
        typer.Option("--width", help="Of a figure for a paper, in in, cm, mm or pt (of TeX).", show_default="3.4in"),
    ] = None,
    by_group: Annotated[
        bool, typer.Option("--by-group", help="An image of episodes, waiting and workload for each group of agents.")
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", "-o", metavar="DIR", help="Where to put the images.", show_default="plots/ in the directory"
        ),
    ] = None,
    kind: Annotated[Literal["png", "svg", "pdf"], typer.Option("--format", "-f", help="File format.")] = "png",
) -> None:
    """Draw a run, a sweep, several runs or a training.

    Of a run: D distance, E exploration, H of a hole, B of a box, and fields of your own: a panel an
    episode, as at its end. map shows boxes, holes, agents and blocked edges (red slashes) at the start
    and the end, trajectories the ways of agents and boxes (blue), episodes steps and
    success by episode, waiting what agents did over an episode's time and how long they waited in
    each, workload the steps of each agent and how evenly they are shared (Gini coefficient),
    fates where each box ended and how often. Of single pushes (`colonysim evaluate push --out`) there are
    trajectories, a panel a terrain, and samples, a panel a push; of a training (`colonysim
    train push`) its learning curve, of a fit (`colonysim train way`) its calibration.

    Of sweeps, of the futures of a run and of several runs: means shows success and steps along a
    parameter with 95 % intervals over seeds, heatmap by two parameters that are numbers, curves by
    episode, differences between settings, paired by seed. What there is no data for is left out,
    and standard error says so.
    """
    from colonysim.cli.console import print_result
    from colonysim.cli.extras import need
    from colonysim.cli.numbers import read_numbers, read_span
    from colonysim.cli.opening import opened

    need("matplotlib", "plot", "drawing")
    from colonysim.errors import ColonysimError
    from colonysim.plots import draw, draw_results, draw_training, is_training
    from colonysim.sweep.tables import is_sweep

    wanted = None
    if what is not None:
        wanted = tuple(dict.fromkeys(word.strip() for word in what.split(",") if word.strip()))
    path = paths[0]
    of_run = [
        name for name, value in (("--hole", hole), ("--box", box), ("--by-group", by_group or None))
        if value is not None
    ]  # fmt: skip
    of_results = [name for name, value in (("--x", x), ("--by", by or None), ("--y", y)) if value is not None]
    if len(paths) > 1 or is_sweep(path):
        if of_run:
            raise ColonysimError(f"{of_run[0]}: only of one run")
        images = draw_results(
            paths, what=wanted, x=x, by=by or None, y=y, episodes=read_span(episodes), out=out, kind=kind, style=style,
            width=width,
        )  # fmt: skip
    elif of_results:
        raise ColonysimError(f"{of_results[0]}: only of a sweep or of several runs")
    elif is_training(path):
        if what not in (None, "learning") or episodes is not None or of_run:
            raise ColonysimError(f"{path}: a training, of which there is one image only; leave the choice out")
        images = draw_training(path, out=out, kind=kind, style=style, width=width)
    else:
        chosen = None if episodes is None else read_numbers(episodes)
        run = opened(path) if what else opened(path, "frames", "poses")
        images = draw(
            run, what=wanted, episodes=chosen, hole=hole, box=box, by_group=by_group, out=out, kind=kind, style=style,
            width=width,
        )  # fmt: skip
    for image in images:
        print_result(shown_path(image))
