"""Images as files: a figure for each name, written in one step, and those left out that would be empty."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING

from colonysim.arguments import real
from colonysim.errors import ColonysimError, ColonysimWarning, MissingExtraError
from colonysim.files import replacing
from colonysim.installing import install_command
from colonysim.plots.sheet import EmptyFigureError
from colonysim.suggest import nearest

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from matplotlib.figure import Figure

    from colonysim.plots.sheet import Sheet

__all__ = ["Job", "dpi_of", "drawn", "need_matplotlib", "not_empty", "save", "words_of"]

Job = tuple[str, "Callable[[], Figure]"]
"""Name of a file, and what draws it."""
_METADATA: dict[str, dict[str, str | None]] = {
    "png": {"Software": ""}, "svg": {"Date": None}, "pdf": {"CreationDate": None},
}  # fmt: skip
"""File formats; without dates in the files the same run gives the same bytes."""
_DPI = (10.0, 2400.0)
_MOST_INCHES = 200
"""Longest side of an image."""


def need_matplotlib() -> None:
    """Checks that matplotlib is installed.

    Raises:
        MissingExtraError: It is not.
    """
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise MissingExtraError(
            f"drawing needs matplotlib, which is not installed: {install_command('plot')}"
        ) from None


def dpi_of(dpi: float | None, sheet: Sheet) -> float:
    """Pixels an inch: those that are asked for, else what suits the sheet."""
    return (600.0 if sheet.width else 130.0) if dpi is None else real("dpi", dpi, *_DPI)


def words_of(what: Sequence[str]) -> tuple[str, ...]:
    """The kinds of images that are asked for, one or several.

    Raises:
        ColonysimError: There are none.
    """
    words = (what,) if isinstance(what, str) else tuple(what)
    if not words:
        raise ColonysimError("what: expected at least one kind of image")
    return words


def drawn(
    jobs: Sequence[Job], out: Path, kind: str, dpi: float, sheet: Sheet, check: Callable[[Path], None]
) -> list[Path]:
    """Draws and writes what is not empty; tells of what is.

    Raises:
        ColonysimError: There is nothing to draw at all.
    """
    images: list[Path] = []
    paths = {name: out / f"{name}.{kind}" for name, _ in jobs}
    with sheet.drawing():
        for path in paths.values():  # before anything is drawn, which takes long
            check(path)
        for name, figure in not_empty(jobs):
            path = paths[name]
            save(sheet.finish(figure), path, kind, dpi)
            images.append(path)
    return images


def not_empty(jobs: Sequence[Job]) -> Iterator[tuple[str, Figure]]:
    """Each figure that is not empty, with its name; at the end tells of those that are.

    Raises:
        EmptyFigureError: All are.
    """
    empty: dict[str, list[str]] = {}
    for name, make in jobs:
        try:
            figure = make()
        except EmptyFigureError as reason:
            empty.setdefault(str(reason), []).append(name)
            continue
        yield name, figure
    told = "; ".join(f"{', '.join(names)}: {reason}" for reason, names in empty.items())
    if sum(map(len, empty.values())) == len(jobs):
        raise EmptyFigureError(f"nothing to draw: {told}")
    if told:
        warnings.warn(f"left out: {told}", ColonysimWarning, stacklevel=4)


def save(figure: Figure, path: Path, kind: str, dpi: float = 130) -> None:
    """Writes a figure in one step.

    Raises:
        ColonysimError: It cannot be written.
    """
    metadata = _METADATA.get(kind)
    if metadata is None:
        raise ColonysimError(f"no format {kind!r}; {nearest(str(kind), _METADATA)}")
    if max(figure.get_size_inches()) > _MOST_INCHES:
        raise ColonysimError(f"{path}: would be more than {_MOST_INCHES} inches large; choose fewer episodes")
    import matplotlib

    # Ids in SVG are hashes with a salt, by default another one each time.
    with replacing(path) as temporary, matplotlib.rc_context({"svg.hashsalt": "colonysim"}):
        figure.savefig(temporary, format=kind, dpi=dpi, metadata=metadata)
