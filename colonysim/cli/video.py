"""`colonysim video`: an episode of a run as a film."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

import typer

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim video runs/hard-bullet-s0-1 hard.mp4
  colonysim video runs/hard-bullet-s0-1 hard.gif --fps 10 --seconds 12
  colonysim video runs/hard-nodeworld-s0-1 first.mp4 --episode 1 --size 1920x1080
"""


def command(
    path: Annotated[Path, typer.Argument(metavar="RUN", help="A run directory.", show_default=False)],
    out: Annotated[Path, typer.Argument(metavar="FILE", help="The file to write: .mp4 or .gif.", show_default=False)],
    episode: Annotated[
        int | None, typer.Option("--episode", "-e", help="Which.", show_default="the last that is complete")
    ] = None,
    seconds: Annotated[
        float, typer.Option(min=0.1, help="How long the video is; the episode is played faster or slower to fit.")
    ] = 20.0,
    fps: Annotated[int, typer.Option(min=1, max=50, help="Frames a second.")] = 15,
    size: Annotated[
        str | None, typer.Option(metavar="WxH", help="In pixels.", show_default="960x720; of a GIF 480x360")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace a file that is there already.")] = False,
) -> None:
    """Film an episode of a run, seen from above, as MP4 or GIF.

    Robots, boxes and ground are drawn as they were if the run has poses (physics); else everything
    moves evenly from node to node. No screen is needed.
    """
    from colonysim.cli.console import print_result
    from colonysim.cli.extras import need
    from colonysim.cli.opening import opened
    from colonysim.progress import Bar

    for package in ("matplotlib", "PIL", "av"):
        need(package, "video", "a video")
    from colonysim.video import write_video

    run = opened(path, "poses")
    with Bar("filming", total=1.0) as bar:
        made = write_video(
            run, out, episode=episode, seconds=seconds, fps=fps, size=None if size is None else _size(size),
            overwrite=overwrite, progress=bar.move,
        )  # fmt: skip
    print_result(str(made))


def _size(text: str) -> tuple[int, int]:
    found = re.fullmatch(r"(\d{1,5})[x×](\d{1,5})", text.strip())
    if found is None:
        raise typer.BadParameter(f"{text!r} is no size; give width and height, such as 960x720")
    return int(found[1]), int(found[2])
