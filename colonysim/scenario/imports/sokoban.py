"""Reads levels of Sokoban (`.xsb`, `.sok`): boards of characters among lines of text."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from colonysim.arguments import whole
from colonysim.characters import printable
from colonysim.errors import ScenarioError
from colonysim.scenario.imports.drawing import MAX_SQUARES, Drawing, check_size

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["read_sokoban"]

_BOARD = "#@+$*. -_pPbBo"
"""The characters of a board: wall; player, on a storage square; box, on a storage square; storage square; floor (three
ways to write it); and the letters of the last five in files that were sent by e-mail."""
_PLAYERS, _BOXES, _STORES = "@+pP", "$*bB", "+*.PBo"
_ROW = re.compile(rf"(?:[0-9]*[{re.escape(_BOARD)}]|\|)+")
_PART = re.compile(rf"([0-9]*)([{re.escape(_BOARD)}])|[0-9]*.", re.DOTALL)
_COMMENTS = (";", "::", "'")


def read_sokoban(data: bytes, source: str, level: int = 1) -> tuple[Drawing, int]:
    """Reads one level of a file.

    Storage squares become holes as deep as a box is high, and the player the first agent. Squares that it can never
    reach are kept here; whoever makes a scenario of the drawing leaves them out.

    Args:
        data: The file's content.
        source: Its name in messages.
        level: Which level, counted from 1.

    Returns:
        The level, and how many there are.

    Raises:
        ScenarioError: There is no such level, or it is none that could be played; the message names line and column.
    """
    lines = data.decode("utf-8-sig", "replace").replace("\r\n", "\n").replace("\r", "\n").split("\n")
    boards = _boards(lines)
    if not boards:
        raise ScenarioError(f"{source}:1:1: there is no level in this file, expected rows such as #@$.#")
    number = whole("level", level)
    if number > len(boards):
        levels = f"{len(boards)} levels" if len(boards) > 1 else "one level"
        raise ScenarioError(f"{source}: level {number}, but the file has {levels}")
    first, last = boards[number - 1]
    rows, places = _expanded(lines, first, last, source)
    columns = max(map(len, rows))
    check_size(columns, len(rows), f"{source}:{first + 1}:1")

    def at(column: int, row: int) -> str:
        line, found = places[row]
        return f"{source}:{line + 1}:{(found[column] if column < len(found) else found[-1] + 1) + 1}"

    drawing = Drawing(columns, len(rows), at, bytearray(columns * len(rows)))
    start = _draw(drawing, rows, f"{source}:{first + 1}:1", number)
    inside = _inside(drawing, rows, start)
    boxes, stores = (sum(square in inside for square in some) for some in (drawing.boxes, drawing.holes))
    if boxes < stores:
        raise ScenarioError(
            f"{source}:{first + 1}:1: level {number} has {stores} storage squares and only {boxes}"
            f" {'box' if boxes == 1 else 'boxes'}, expected a box for each"
        )
    if start in drawing.holes:
        start = _beside(drawing, start)
    drawing.put("agent", start)
    return drawing, len(boards)


def _boards(lines: Sequence[str]) -> list[tuple[int, int]]:
    """The first line of each board, and the line behind its last one."""
    found: list[tuple[int, int]] = []
    n = 0
    while n < len(lines):
        first = n
        while n < len(lines) and _meant_as_row(lines[n]):
            n += 1
        walled = [k for k in range(first, n) if "#" in lines[k]]
        if any(_ROW.fullmatch(lines[k].rstrip()) for k in walled):
            found.append((walled[0], walled[-1] + 1))
        n += n == first
    return found


def _meant_as_row(line: str) -> bool:
    """Whether a line is a row of a board, or would be one but for a few wrong characters."""
    text = line.rstrip()
    if not text or text.startswith(_COMMENTS):
        return False
    known = sum(character in _BOARD for character in text)
    return _ROW.fullmatch(text) is not None or ("#" in text and 2 * known > len(text))


def _expanded(
    lines: Sequence[str], first: int, last: int, source: str
) -> tuple[list[str], list[tuple[int, list[int]]]]:
    """The rows of a board, run-length encoding undone; for each its line and the columns of its squares there."""
    rows: list[str] = []
    places: list[tuple[int, list[int]]] = []
    squares = 0
    for n in range(first, last):
        text, at = lines[n].rstrip(), 0
        for coded in text.split("|"):
            row, columns = "", []
            for part in _PART.finditer(coded):
                if part[2] is None:
                    wrong = at + part.end() - 1
                    raise ScenarioError(
                        f"{source}:{n + 1}:{wrong + 1}: '{printable(text[wrong])}' in a row of a level,"
                        f" expected one of {' '.join(_BOARD[:6])} and blanks for floor"
                    )
                count = int(part[1] or 1) if len(part[1]) < 10 else MAX_SQUARES + 1
                squares += count
                if squares > MAX_SQUARES:
                    place = f"{source}:{n + 1}:{at + part.start() + 1}"
                    raise ScenarioError(f"{place}: the level has more than {MAX_SQUARES} squares")
                row += part[2] * count
                columns += [at + part.start(2)] * count
            rows.append(row)
            places.append((n, columns or [at]))
            at += len(coded) + 1
    return rows, places


def _draw(drawing: Drawing, rows: Sequence[str], place: str, level: int) -> int:
    """Draws all but the player, whose square is returned."""
    player: int | None = None
    for y, row in enumerate(rows):
        for x, character in enumerate(row):
            if character == "#":
                continue
            square = y * drawing.columns + x
            drawing.put("floor", square)
            if character in _BOXES:
                drawing.put("box", square)
            if character in _STORES:
                drawing.put("hole", square)
            if character in _PLAYERS:
                if player is not None:
                    first = drawing.where(player)
                    raise ScenarioError(f"{drawing.where(square)}: a second player, the first is at {first}")
                player = square
    if player is None:
        raise ScenarioError(f"{place}: level {level} has no player, expected one @, or + on a storage square")
    return player


def _inside(drawing: Drawing, rows: Sequence[str], start: int) -> set[int]:
    """The squares that the player could reach if there were no boxes; they may not lead out of the board."""
    found = set()
    for layer in drawing.layers(start, drawing.walls()):
        for square in layer:
            y, x = divmod(square, drawing.columns)
            around = ((x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1))
            if any(not 0 <= j < len(rows) or not 0 <= i < len(rows[j]) for i, j in around):
                raise ScenarioError(
                    f"{drawing.where(square)}: the player can leave the board here, expected walls all around"
                )
        found.update(layer)
    return found


def _beside(drawing: Drawing, start: int) -> int:
    """The free square that is nearest to one; of several the uppermost, then the leftmost."""
    for layer in drawing.layers(start, drawing.walls()):
        free = [square for square in layer if square not in drawing.holes and square not in drawing.boxes]
        if free:
            return min(free)
    raise ScenarioError(
        f"{drawing.where(start)}: the player stands on a storage square, and no square is free for the agent"
    )
