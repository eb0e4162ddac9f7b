"""Maps in the formats that people have: each is read into a drawing, and one place makes scenarios of drawings."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

from colonysim.characters import printable
from colonysim.errors import ColonysimError, ScenarioError
from colonysim.files import read_file, read_json, shown_path
from colonysim.suggest import nearest

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

__all__ = ["FORMATS", "Format", "import_map"]

Format = Literal["movingai", "sokoban", "png", "tiled"]
FORMATS: tuple[Format, ...] = get_args(Format)
_ENDINGS: dict[str, Format] = {
    ".map": "movingai", ".xsb": "sokoban", ".sok": "sokoban", ".png": "png", ".tmj": "tiled", ".json": "tiled",
}  # fmt: skip
_MAX_BYTES = 64_000_000
"""Largest file that is read."""


def import_map(
    path: str | Path,
    *,
    format: Format | None = None,
    level: int | None = None,
    floor: str | None = None,
    colours: Mapping[str, str] | None = None,
    tolerance: int | None = None,
    crop: Sequence[int] | None = None,
    spacing: float = 1.0,
    diagonals: bool = False,
    agents: int | Sequence[Sequence[int]] | None = None,
    goal: Sequence[int] | None = None,
    seed: int = 0,
) -> dict[str, Any]:
    """Makes a scenario document of a map; it was checked as a scenario file would be.

    Each square of floor becomes a node, and walls become nothing. The uppermost row of the map has the largest y, so
    that plots show it as it was drawn. Columns and rows are counted from 0, from the upper left corner of the file.

    Args:
        path: The file.
        format: "movingai", "sokoban", "png" or "tiled"; None for what its ending says.
        level: Of a Sokoban file, which level, from 1; the first by default.
        floor: Of a MovingAI map, the characters that become floor; ".GS" by default.
        colours: Of a picture, what further colours mean, or other ones: {"#c0c0c0": "floor"}.
        tolerance: Of a picture, how much each of red, green and blue may differ from a colour that means something.
        crop: Only columns x0 to x1 and rows y0 to y1 are kept, both included: (x0, y0, x1, y1).
        spacing: Distance of neighbours, graph units.
        diagonals: Whether diagonal neighbours are joined too, where both squares beside the diagonal are floor.
        agents: How many there are in all: those that the map does not have are drawn from the free floor; or the
            (column, row) of each besides those of the map. By default the map's, or four where it has none.
        goal: (column, row) of the goal. By default the map's; where it has none, the free square farthest from the
            first agent, of those that only a way over holes reaches if there are any.
        seed: Of the agents that are drawn.

    Raises:
        ScenarioError: The file is no such map, or makes no scenario; the message names line and column, pixel or
            square.
        ColonysimError: It cannot be read, or an argument is wrong, or without meaning for this format.
        MissingExtraError: It is a picture, and Pillow is not installed.

    Example:
        ```python
        document = colonysim.import_map("arena.map", agents=8, seed=1)
        run = colonysim.run(colonysim.scenario_from_document(document))
        ```
    """
    from colonysim.scenario.imports.document import to_document

    path = Path(path)
    kind = _format(path, format)
    _refuse_others(kind, {"level": level, "floor": floor, "colours": colours, "tolerance": tolerance})
    shown = printable(shown_path(path), 300)
    name, what = path.stem, path.name
    if kind == "tiled":
        from colonysim.scenario.imports.tiled import read_tiled

        drawing = read_tiled(read_json(path, ScenarioError, _MAX_BYTES), shown)
    elif kind == "png":
        from colonysim.scenario.imports.picture import read_picture

        drawing = read_picture(read_file(path, ScenarioError, _MAX_BYTES), shown, colours, tolerance or 0)
    elif kind == "movingai":
        from colonysim.scenario.imports.movingai import FLOOR, read_movingai

        data = read_file(path, ScenarioError, _MAX_BYTES)
        drawing = read_movingai(data, shown, FLOOR if floor is None else floor)
    else:
        from colonysim.scenario.imports.sokoban import read_sokoban

        number = 1 if level is None else level
        drawing, levels = read_sokoban(read_file(path, ScenarioError, _MAX_BYTES), shown, number)
        if levels > 1:
            name, what = f"{name}-{number}", f"{what}, level {number} of {levels}"
    return to_document(
        drawing, shown, name, what, crop=crop, spacing=spacing, diagonals=diagonals, agents=agents, goal=goal, seed=seed
    )


def _format(path: Path, asked: str | None) -> Format:
    """The format that is asked for, or that a file's ending says."""
    if asked is not None:
        found = next((each for each in FORMATS if each == asked), None)
        if found is None:
            raise ColonysimError(f"format: no format {printable(str(asked))!r}; {nearest(str(asked), FORMATS)}")
        return found
    if path.suffix.lower() not in _ENDINGS:
        raise ColonysimError(
            f"{printable(str(path), 300)}: its ending does not say what map it is, expected one of"
            f" {', '.join(_ENDINGS)}, or a format: {', '.join(FORMATS)}"
        )
    return _ENDINGS[path.suffix.lower()]


_ONLY: dict[str, tuple[Format, str]] = {
    "level": ("sokoban", "only Sokoban files have levels"),
    "floor": ("movingai", "only of MovingAI maps it says which characters are floor"),
    "colours": ("png", "only pictures have colours"),
    "tolerance": ("png", "only pictures have colours"),
}


def _refuse_others(kind: Format, given: Mapping[str, Any]) -> None:
    """Refuses what would be without effect."""
    for name, value in given.items():
        only, why = _ONLY[name]
        if value is not None and kind != only:
            raise ColonysimError(f"{name}: {why}, and this is read as {kind}")
