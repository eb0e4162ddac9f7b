"""`colonysim view`: watch a run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from colonysim.files import shown_path

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim view runs/hard-nodeworld-s0-1
  colonysim view runs/hard-bullet-s0-1 -o hard.html --no-open
  colonysim view runs/hard-nodeworld-s0-1 --episodes 1,3,10-12
"""


def command(
    path: Annotated[Path, typer.Argument(metavar="RUN", help="A run directory.", show_default=False)],
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", "-o", metavar="FILE", help="The page to write.", show_default="view.html in the run directory"
        ),
    ] = None,
    episodes: Annotated[
        str | None,
        typer.Option("--episodes", help="Which, such as 1,3,10.", show_default="all, or the last that make 20 MB"),
    ] = None,
    no_open: Annotated[bool, typer.Option("--no-open", help="Write the page; do not open it.")] = False,
) -> None:
    """Watch a run: write it as one HTML page and open it in the browser.

    The page holds everything it needs and asks no network for anything: it can be sent, kept
    and opened anywhere. It replays map, agents, boxes, pheromones and decisions; of a run with
    rigid bodies it also shows the scene in 3D. Press ? in it for the keys.

    Of a long run it shows the last episodes that make a page of about 20 MB, of a large episode no
    pheromones and no decisions, unless --episodes asks for more, and says so; a page of more than
    100 MB is refused. What was not recorded is not shown, and named.
    """
    from colonysim.cli.console import print_result, say
    from colonysim.cli.numbers import read_numbers
    from colonysim.cli.opening import opened
    from colonysim.progress import Bar
    from colonysim.view import write_page

    chosen = None if episodes is None else read_numbers(episodes)
    run = opened(path)
    with Bar(f"reading {shown_path(path)}", total=1.0) as bar:
        page = write_page(run, out, chosen, tell=say, progress=bar.move)
    print_result(shown_path(page))
    if not no_open:
        import webbrowser

        webbrowser.open(page.resolve().as_uri())
