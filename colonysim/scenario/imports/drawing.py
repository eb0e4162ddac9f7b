"""What a reader of maps makes of its file: squares that are floor or wall, and what stands on them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, get_args

from colonysim.errors import ScenarioError
from colonysim.scenario.invent import HEIGHT

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

__all__ = ["KINDS", "MAX_SQUARES", "Drawing", "Kind", "check_size"]

Kind = Literal["wall", "floor", "box", "hole", "agent", "goal"]
KINDS: tuple[Kind, ...] = get_args(Kind)

MAX_SQUARES = 16_777_216
"""Most squares of a map that is read, 4096 x 4096; how many a scenario may keep of them is another matter."""


def check_size(columns: int, rows: int, place: str) -> None:
    """Refuses a map that is too large, before there is memory for its squares.

    Raises:
        ScenarioError: It has more than `MAX_SQUARES`.
    """
    if columns * rows > MAX_SQUARES:
        raise ScenarioError(
            f"{place}: {columns} x {rows} squares are {columns * rows}, expected at most {MAX_SQUARES}"
        )


@dataclass(slots=True)
class Drawing:
    """A map. Its squares are numbered row by row from the upper left one: `row * columns + column`.

    Attributes:
        columns: Squares to a row.
        rows: How many rows.
        at: Names the square of a column and row of the file in messages: "cave.map:7:3".
        floor: A byte for each square: 1 for floor, also below a box, an agent or the goal and in a hole; 0 for wall.
        holes: Depth of each hole by its square, graph units.
        boxes: Height of each box by its square, graph units.
        agents: The squares on which agents start, in their order.
        goal: The square that they must reach; None if the map does not say.
        left: The column of the file at which column 0 lies, after `crop`.
        top: The row of the file at which row 0 lies.
    """

    columns: int
    rows: int
    at: Callable[[int, int], str]
    floor: bytearray
    holes: dict[int, float] = field(default_factory=dict)
    boxes: dict[int, float] = field(default_factory=dict)
    agents: list[int] = field(default_factory=list)
    goal: int | None = None
    left: int = 0
    top: int = 0

    def where(self, square: int) -> str:
        """Where a square lies in the file, for a message."""
        return self.at(*self.point(square))

    def point(self, square: int) -> tuple[int, int]:
        """Column and row of a square in the file."""
        row, column = divmod(square, self.columns)
        return column + self.left, row + self.top

    def put(self, kind: Kind, square: int, size: float = HEIGHT) -> None:
        """Says what a square is, or what is on it.

        Args:
            kind: What.
            square: Which square.
            size: The height of a box or the depth of a hole, graph units.

        Raises:
            ScenarioError: The same is there already, or there is another goal.
        """
        self.floor[square] = kind != "wall"
        if kind in ("wall", "floor"):
            return
        if square in {"box": self.boxes, "hole": self.holes, "agent": self.agents, "goal": ()}[kind]:
            raise ScenarioError(f"{self.where(square)}: a second {kind} on this square, expected one")
        if kind == "box":
            self.boxes[square] = size
        elif kind == "hole":
            self.holes[square] = size
        elif kind == "agent":
            self.agents.append(square)
        elif self.goal is None:
            self.goal = square
        else:
            raise ScenarioError(f"{self.where(square)}: a second goal, the first is at {self.where(self.goal)}")

    def crop(self, x0: int, y0: int, x1: int, y1: int) -> Drawing:
        """The part from column x0 and row y0 to column x1 and row y1, these included."""
        columns, rows = x1 - x0 + 1, y1 - y0 + 1
        floor = bytearray().join(
            self.floor[row * self.columns + x0 : row * self.columns + x1 + 1] for row in range(y0, y1 + 1)
        )

        def moved(square: int) -> int | None:
            row, column = divmod(square, self.columns)
            inside = x0 <= column <= x1 and y0 <= row <= y1
            return (row - y0) * columns + column - x0 if inside else None

        return Drawing(
            columns, rows, self.at, floor,
            {new: size for old, size in self.holes.items() if (new := moved(old)) is not None},
            {new: size for old, size in self.boxes.items() if (new := moved(old)) is not None},
            [new for old in self.agents if (new := moved(old)) is not None],
            None if self.goal is None else moved(self.goal), x0, y0,
        )  # fmt: skip

    def walls(self) -> bytearray:
        """A byte for each square: 1 for wall, 0 for floor."""
        return self.floor.translate(bytes([1, 0]) + bytes(254))

    def layers(self, start: int, closed: bytearray) -> Iterator[list[int]]:
        """The squares that can be reached from one, by steps to the left, right, up and down: those at distance 0, 1...

        Args:
            start: The square.
            closed: A byte for each square, 1 where no step leads; squares that are reached are set to 1.
        """
        columns, end = self.columns, self.columns - 1
        lowest = len(closed) - columns
        closed[start] = 1
        layer = [start]
        while layer:
            yield layer
            following = []
            for square in layer:
                column = square % columns
                for step, there in (
                    (-1, column > 0), (1, column < end), (-columns, square >= columns), (columns, square < lowest),
                ):  # fmt: skip
                    if there and not closed[square + step]:
                        closed[square + step] = 1
                        following.append(square + step)
            layer = following
