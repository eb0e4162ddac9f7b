"""An episode of a stored run as a video, seen from above: drawn and written without a screen."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from colonysim.arguments import real, whole, wholes
from colonysim.errors import ColonysimError, TraceError
from colonysim.files import replacing

if TYPE_CHECKING:
    from collections.abc import Callable

    from colonysim.trace.reader import Run
    from colonysim.trace.schema import EpisodeResult

__all__ = ["SIZES", "write_video"]

SIZES = {".mp4": (960, 720), ".gif": (480, 360)}
"""The endings that can be written, and the size in pixels if none is asked for."""
_SMALLEST, _LARGEST = 160, 4096
_MOST_FRAMES = 36_000
_FASTEST = 50
"""Frames a second; players of GIF show no more."""


def write_video(
    run: Run,
    out: str | Path,
    *,
    episode: int | None = None,
    seconds: float = 20.0,
    fps: int = 15,
    size: tuple[int, int] | None = None,
    overwrite: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Writes an episode as a video and returns its path; the file appears once it is complete.

    Args:
        run: The run. Where it has poses the bodies are drawn as they were, else they move from node to node.
        out: The file to write; its ending says what it becomes, MP4 (H.264) or GIF.
        episode: Which; None for the last one that is complete.
        seconds: Length of the video; the episode is played faster or slower to fit.
        fps: Frames a second, at most 50.
        size: Width and height in pixels; None for what `SIZES` says.
        overwrite: Whether a file that is there already may be replaced.
        progress: Is told after each frame how many are done, and of how many.

    Raises:
        TraceError: The run kept no trace, is one of single pushes, has no such episode, or `out` is part of it.
        ColonysimError: Nothing can be written to that path, or not in that size or length.
    """
    path = Path(out)
    ending = path.suffix.lower()
    if ending not in SIZES:
        raise ColonysimError(f"{path}: a video ends in {' or '.join(SIZES)}")
    run.check_apart(path)
    if not overwrite and _exists(path):
        raise ColonysimError(f"{path}: exists already; it is not overwritten")
    width, height = _size(size or SIZES[ending])
    if ending == ".mp4" and (width % 2 or height % 2):
        raise ColonysimError(f"an MP4 of {width}x{height} cannot be made: width and height must be even")
    fps = whole("fps", fps, 1, _FASTEST)
    seconds = real("seconds", seconds, 0.0, 1e9)
    if not 0.5 < seconds * fps <= _MOST_FRAMES:
        raise ColonysimError(f"{seconds:g} s with {fps} frames a second: a video has 1 to {_MOST_FRAMES} frames")
    result = _result(run, episode)
    run.check_places("events", "poses")

    from colonysim.video.encode import encode
    from colonysim.video.film import Film

    film = Film(run.only([result.episode]), result, frames=round(seconds * fps), fps=fps, size=(width, height))
    with replacing(path) as temporary:
        encode(film, temporary, ending, progress or (lambda done, total: None))
    return path


def _size(size: tuple[int, int]) -> tuple[int, int]:
    pixels = wholes("size", size)
    if len(pixels) != 2 or not all(_SMALLEST <= number <= _LARGEST for number in pixels):
        shown = "x".join(map(str, pixels))
        raise ColonysimError(f"a video of {shown} cannot be made; expected {_SMALLEST} to {_LARGEST} pixels each way")
    return pixels[0], pixels[1]


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except OSError as error:
        raise ColonysimError(f"{path}: cannot be written: {error.strerror or error}") from None


def _result(run: Run, episode: int | None) -> EpisodeResult:
    if not run.episodes:
        raise TraceError(f"{run.path}: no episode of this run is complete, so there is nothing to show yet")
    if episode is None:
        return run.episodes[-1]
    episode = whole("episode", episode)
    for result in run.episodes:
        if result.episode == episode:
            return result
    raise TraceError(
        f"no episode {episode} in this run; it has {run.episodes[0].episode} to {run.episodes[-1].episode}"
    )
