"""From images to a file: H.264 in MP4 by PyAV, GIF by Pillow."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from PIL.Image import Image

__all__ = ["encode"]

_QUALITY = "20"
"""x264's constant rate factor: lower is better and larger."""
_FLAT, _BLENDED = 127, 128
"""Colours of a GIF's palette: of surfaces, and of the soft edges between them. Pillow marks what did not change by the
index that is left."""


class Images(Protocol):
    """Images of one size, drawn when they are asked for: height x width x 3, 8 bits each.

    Attributes:
        fps: Frames a second.
        size: Width and height, pixels.
    """

    fps: int
    size: tuple[int, int]

    def __len__(self) -> int:
        """How many there are."""
        ...

    def __getitem__(self, number: int, /) -> np.ndarray[Any, Any]:
        """One of them."""
        ...


def encode(film: Images, path: Path, ending: str, progress: Callable[[int, int], None]) -> None:
    """Writes all images of a film, or of whatever else has some.

    Args:
        film: The images.
        path: The file; it is overwritten.
        ending: ".mp4" or ".gif".
        progress: Is told how many images are done, and of how many.

    Raises:
        OSError: The file cannot be written.
    """
    {".mp4": _mp4, ".gif": _gif}[ending](film, path, progress)


def _mp4(film: Images, path: Path, progress: Callable[[int, int], None]) -> None:
    import av

    try:
        _encode(film, path, progress)
    except av.error.FFmpegError as error:
        # Some of its errors are no OSError, also those of a disk that is full.
        raise error if isinstance(error, OSError) else OSError(error.errno, error.strerror) from error


def _encode(film: Images, path: Path, progress: Callable[[int, int], None]) -> None:
    import av

    with av.open(str(path), "w", format="mp4", options={"movflags": "+faststart"}) as container:
        stream = container.add_stream("libx264", rate=Fraction(film.fps), options={"crf": _QUALITY})
        stream.width, stream.height = film.size
        stream.pix_fmt = "yuv420p"  # the one that every player knows
        for i in range(len(film)):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(film[i], format="rgb24")))
            progress(i + 1, len(film))
        container.mux(stream.encode())


def _gif(film: Images, path: Path, progress: Callable[[int, int], None]) -> None:
    """One palette for all images and no dithering: what does not change costs nothing."""
    from PIL import Image

    palette = _palette(film)

    def images() -> Iterator[Image.Image]:
        for i in range(len(film)):
            yield Image.fromarray(film[i]).quantize(palette=palette, dither=Image.Dither.NONE)
            progress(i + 1, len(film))

    # Hundredths of a second, rounded so that the whole keeps its length.
    ends = np.rint(np.arange(len(film) + 1) * 100 / film.fps)
    shown = images()
    next(shown).save(
        path, format="GIF", save_all=True, append_images=shown, duration=(np.diff(ends) * 10).astype(int).tolist(),
        loop=0, optimize=False,
    )  # fmt: skip


def _palette(film: Images) -> Image:
    """The commonest colours of some images as they are, and a choice of the others; one index stays free."""
    from PIL import Image

    some = np.concatenate([film[int(i)] for i in np.unique(np.linspace(0, len(film) - 1, 5).round())])
    colors, counts = np.unique(some.reshape(-1, 3), axis=0, return_counts=True)
    flat = colors[np.argsort(-counts, kind="stable")][:_FLAT]
    blended = Image.fromarray(some).quantize(_BLENDED).getpalette() or []
    palette = Image.new("P", (1, 1))
    palette.putpalette([*flat.ravel().tolist(), *blended])
    return palette
