"""Reads the maps of the Moving AI pathfinding benchmarks (`.map`): a header of four lines, and a character a square."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from colonysim.arguments import shown
from colonysim.characters import printable
from colonysim.errors import ColonysimError, ScenarioError
from colonysim.scenario.imports.drawing import Drawing, check_size

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["FLOOR", "read_movingai"]

TERRAIN = ".GS@OTW"
"""The characters of the format: ground (. and G), swamp, out of bounds (@ and O), trees, water."""
FLOOR = ".GS"
"""Those on which agents stand unless it is said otherwise."""
_TYPES = ("octile", "tile")
_NUMBER = re.compile(rb"[0-9]{1,9}")


def read_movingai(data: bytes, source: str, floor: str = FLOOR) -> Drawing:
    """Reads a map.

    Args:
        data: The file's content.
        source: Its name in messages.
        floor: The characters that become floor; all others become wall.

    Raises:
        ScenarioError: It is no such map; the message names line and column.
        ColonysimError: `floor` holds other characters, or none.
    """
    if not isinstance(floor, str) or not floor or set(floor) - set(TERRAIN):
        raise ColonysimError(f"floor: {shown(floor)}, expected some of the characters {' '.join(TERRAIN)}")
    lines = data.replace(b"\r\n", b"\n").split(b"\n")
    sizes, start = _header(lines, source)
    columns, rows = sizes["width"], sizes["height"]
    check_size(columns, rows, source)
    drawn = lines[start : start + rows]
    if drawn and start + len(drawn) == len(lines) and not drawn[-1]:
        del drawn[-1]  # what follows the end of the last line
    for n, row in enumerate(drawn, start + 1):
        unknown = row.translate(None, TERRAIN.encode())[:1]
        if unknown and row.index(unknown) < columns:
            place = f"{source}:{n}:{row.index(unknown) + 1}"
            raise ScenarioError(f"{place}: '{_shown(unknown)}', expected one of {' '.join(TERRAIN)}")
        if len(row) != columns:
            place = f"{source}:{n}:{min(len(row), columns) + 1}"
            raise ScenarioError(f"{place}: the row has {len(row)} squares, expected {columns} as `width` says")
    if len(drawn) < rows:
        place = f"{source}:{start + len(drawn) + 1}:1"
        raise ScenarioError(f"{place}: the map ends after {len(drawn)} rows, expected {rows} as `height` says")
    for n, row in enumerate(lines[start + rows :], start + rows + 1):
        if row.strip():
            raise ScenarioError(f"{source}:{n}:1: '{_shown(row)}' stands below the last row, as `height` is {rows}")
    table = bytes(chr(code) in floor for code in range(256))

    def at(column: int, row: int) -> str:
        return f"{source}:{start + row + 1}:{column + 1}"

    return Drawing(columns, rows, at, bytearray(b"".join(drawn).translate(table)))


def _header(lines: Sequence[bytes], source: str) -> tuple[dict[str, int], int]:
    """Width and height by name, and the index of the line of the first row."""
    sizes: dict[str, int] = {}
    expected = "`type octile`"
    for n, line in enumerate(lines):
        words = line.split()
        name = words[0].decode("latin-1") if words else ""

        def fault(what: str, column: int = 1, n: int = n) -> ScenarioError:
            return ScenarioError(f"{source}:{n + 1}:{column}: {what}")

        if n == 0:
            if name != "type" or len(words) != 2:
                raise fault(f"{_quoted(line)}, expected {expected}")
            kind = words[1].decode("latin-1")
            if kind not in _TYPES:
                raise fault(f"a map of the type '{_shown(words[1])}', expected {' or '.join(_TYPES)}",
                            line.index(words[1]) + 1)  # fmt: skip
        elif name == "map" and len(words) == 1:
            if len(sizes) == 2:
                return sizes, n + 1
            raise fault(f"the map begins here, expected {expected} before it")
        elif name in ("height", "width") and name not in sizes and len(words) == 2:
            if not _NUMBER.fullmatch(words[1]) or not int(words[1]):
                raise fault(f"'{_shown(words[1])}', expected the {name} in squares, a whole number from 1",
                            line.index(words[1]) + 1)  # fmt: skip
            sizes[name] = int(words[1])
        else:
            raise fault(f"{_quoted(line)}, expected {expected}")
        missing = [f"`{name} ...`" for name in ("height", "width") if name not in sizes]
        expected = " or ".join(missing) or "`map`"
    raise ScenarioError(f"{source}:{len(lines)}:1: the file ends in its header, expected {expected}")


def _quoted(line: bytes) -> str:
    return f"'{_shown(line)}'" if line.strip() else "nothing stands here"


def _shown(text: bytes) -> str:
    return printable(text.decode("latin-1"), 30)

