"""From a drawing to a scenario document: what is kept of it, where agents start, where they go."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

from colonysim.arguments import MAX_COUNT, as_seed, plain, real, shown, whole
from colonysim.characters import printable
from colonysim.errors import ColonysimError, ColonysimWarning, ScenarioError
from colonysim.scenario.format import MAX_NAME
from colonysim.scenario.generate import MAX_NODES, draw_some
from colonysim.scenario.invent import to_yaml
from colonysim.scenario.loading import scenario_from_document
from colonysim.scenario.sections import LARGEST, SMALLEST
from colonysim.scenario.source import MAX_BYTES, MAX_VALUES

if TYPE_CHECKING:
    from collections.abc import Sequence

    from colonysim.scenario.imports.drawing import Drawing

__all__ = ["to_document"]

_AGENTS = 4
"""How many agents are drawn where neither the map nor the caller says so."""


def to_document(
    drawing: Drawing,
    source: str,
    name: str,
    what: str,
    *,
    crop: Sequence[int] | None,
    spacing: float,
    diagonals: bool,
    agents: int | Sequence[Sequence[int]] | None,
    goal: Sequence[int] | None,
    seed: int,
) -> dict[str, Any]:
    """A scenario document, checked as a file would be.

    The part of the floor that holds the goal and the agents is kept; what is not joined with it is left out. Node
    `(rows - 1 - row) * columns + column` is the square of that column and row.

    Args:
        drawing: The map; it is changed.
        source: The file's name in messages.
        name: The scenario's name.
        what: What the description says that it was imported from.
        crop: As for `import_map`, like all that follow.
        spacing: Distance of neighbours, graph units.
        diagonals: Whether diagonal neighbours are joined too.
        agents: How many, or where.
        goal: Where it is.
        seed: Of the agents that are drawn.

    Raises:
        ScenarioError: The map makes no scenario.
        ColonysimError: An argument is wrong.
    """
    spacing, seed = real("spacing", spacing, SMALLEST, LARGEST), as_seed(seed)
    if crop is not None:
        drawing = _cropped(drawing, crop)
    columns, rows = drawing.columns, drawing.rows
    if columns * rows > MAX_NODES:
        raise ScenarioError(
            f"{source}: {columns} x {rows} squares are {columns * rows}, expected at most {MAX_NODES};"
            " crop keeps a part: x0,y0,x1,y1"
        )
    if goal is not None:
        drawing.goal = _listed(drawing, "goal", goal)
    wanted = _add_agents(drawing, agents)
    if drawing.goal is not None:
        _refuse_shared(drawing, drawing.goal, "goal")
    for agent in drawing.agents:
        _refuse_shared(drawing, agent, "agent")
    part = _part(drawing, drawing.walls(), source, "no floor joins them")
    _keep(drawing, part)
    room = part
    if not drawing.boxes:  # nobody can ever cross a hole
        room = _part(drawing, _without_holes(drawing), source, "only holes join them, and there are no boxes")
    _draw_agents(drawing, room, wanted, seed, source)
    if drawing.goal is None:
        drawing.goal = _farthest(drawing, source)
    extent = sum(1 for _ in drawing.layers(drawing.goal, drawing.walls()))

    def node(square: int) -> int:
        row, column = divmod(square, columns)
        return (rows - 1 - row) * columns + column

    topology: dict[str, Any] = {"kind": "grid", "columns": columns, "rows": rows}
    if spacing != 1.0:
        topology["spacing"] = spacing
    if diagonals:
        topology |= {"diagonals": True, "cut_corners": False}
    if len(part) < columns * rows:
        topology["without"] = sorted(node(square) for square, floor in enumerate(drawing.floor) if not floor)
    document: dict[str, Any] = {
        "name": printable(name, MAX_NAME)[:MAX_NAME] if name.strip() else "map",
        "description": f"Imported from {printable(what)}: {len(part)} of {columns} x {rows} squares.",
        "topology": topology,
        "holes": [{"node": node(square), "depth": depth} for square, depth in sorted(drawing.holes.items())],
        "boxes": [[node(square), height] for square, height in sorted(drawing.boxes.items())],
        "agents": [node(square) for square in drawing.agents],
        "goal": node(drawing.goal),
        "max_steps": min(50 + 6 * extent, MAX_COUNT),
    }
    _refuse_long(document, source)
    scenario_from_document(document, source=source)
    return document


def _cropped(drawing: Drawing, crop: Any) -> Drawing:
    borders = plain(crop)
    if not isinstance(borders, (list, tuple)) or len(borders) != 4:
        raise ColonysimError(f"crop: {shown(crop)}, expected x0, y0, x1 and y1")
    ends = (drawing.columns, drawing.rows, drawing.columns, drawing.rows)
    x0, y0, x1, y1 = (
        whole(f"crop: {name}", value, 0, end - 1)
        for name, value, end in zip(("x0", "y0", "x1", "y1"), borders, ends, strict=True)
    )
    if x0 > x1 or y0 > y1:
        raise ColonysimError(f"crop: {x0},{y0},{x1},{y1}, expected the smaller column and row first")
    return drawing.crop(x0, y0, x1, y1)


def _listed(drawing: Drawing, what: str, point: Any) -> int:
    """The square of floor of a (column, row) that the caller gave."""
    pair = plain(point)
    if not isinstance(pair, (list, tuple)) or len(pair) != 2:
        raise ColonysimError(f"{what}: {shown(point)}, expected a column and a row")
    left, top = drawing.left, drawing.top
    column = whole(f"{what}: column", pair[0], left, left + drawing.columns - 1) - left
    row = whole(f"{what}: row", pair[1], top, top + drawing.rows - 1) - top
    square = row * drawing.columns + column
    if not drawing.floor[square]:
        raise ColonysimError(f"{what}: {pair[0]},{pair[1]} is wall ({drawing.where(square)}), expected floor")
    return square


def _add_agents(drawing: Drawing, agents: Any) -> int:
    """Puts those that are listed on the drawing; how many there have to be in all."""
    if agents is None:
        return len(drawing.agents) or _AGENTS
    agents = plain(agents)
    if not isinstance(agents, (list, tuple)):
        number = whole("agents", agents)
        if number < len(drawing.agents):
            raise ColonysimError(f"agents: {number}, but the map has {len(drawing.agents)}; expected at least as many")
        return number
    if not agents:
        raise ColonysimError("agents: an empty list, expected a number, or a column and a row for each")
    for point in agents:
        drawing.put("agent", _listed(drawing, "agents", point))
    return len(drawing.agents)


def _refuse_shared(drawing: Drawing, square: int, what: str) -> None:
    """Refuses a goal or an agent in a hole, under a box, or both on one square."""
    other = "hole" if square in drawing.holes else "box" if square in drawing.boxes else ""
    if not other and what == "agent" and square == drawing.goal:
        other = "goal"
    if other:
        at = "{},{}".format(*drawing.point(square))
        raise ScenarioError(f"{drawing.where(square)}: the {what} at {at} shares its square with a {other},"
                            " expected free floor")  # fmt: skip


def _without_holes(drawing: Drawing) -> bytearray:
    """A byte for each square, 1 for walls and for holes that no box fills."""
    closed = drawing.walls()
    for hole in drawing.holes:
        closed[hole] = hole not in drawing.boxes
    return closed


def _part(drawing: Drawing, closed: bytearray, source: str, apart: str) -> list[int]:
    """The squares joined with the goal and the agents; the largest part if there are none.

    Args:
        drawing: The map.
        closed: A byte for each square, 1 where no step leads; it is changed.
        source: The file's name in messages.
        apart: Why an agent cannot come to the goal.
    """
    if drawing.goal is not None or drawing.agents:
        start, what = (drawing.agents[0], "first agent") if drawing.goal is None else (drawing.goal, "goal")
        part = [square for layer in drawing.layers(start, closed) for square in layer]
        agent = next((agent for agent in drawing.agents if not closed[agent]), None)
        if agent is not None:
            way = f"from here to the {what} at {drawing.where(start)}"
            raise ScenarioError(f"{drawing.where(agent)}: no way leads the agent {way}: {apart}")
        return part
    part = []
    start = closed.find(0)
    while start >= 0:
        found = [square for layer in drawing.layers(start, closed) for square in layer]
        part = max(part, found, key=len)
        start = closed.find(0, start)
    if not part:
        raise ScenarioError(f"{source}: no floor among {drawing.columns} x {drawing.rows} squares, expected some")
    return part


def _keep(drawing: Drawing, part: Sequence[int]) -> None:
    """Makes wall of whatever is not in a part, and warns of boxes and holes that this takes away."""
    floor = bytearray(len(drawing.floor))
    for square in part:
        floor[square] = 1
    drawing.floor = floor
    for things, one, many in ((drawing.boxes, "box", "boxes"), (drawing.holes, "hole", "holes")):
        lost = [square for square in things if not floor[square]]
        for square in lost:
            del things[square]
        if lost:
            number = f"1 {one} is" if len(lost) == 1 else f"{len(lost)} {many} are"
            message = f"{drawing.where(lost[0])}: {number} left out here, which no floor joins with goal and agents"
            warnings.warn(message, ColonysimWarning, stacklevel=4)


def _taken(drawing: Drawing) -> set[int | None]:
    """The squares on which nobody may start."""
    return {*drawing.holes, *drawing.boxes, *drawing.agents, drawing.goal}


def _draw_agents(drawing: Drawing, part: Sequence[int], wanted: int, seed: int, source: str) -> None:
    """Draws the squares of the agents that are still missing."""
    missing = wanted - len(drawing.agents)
    taken = _taken(drawing)
    free = [square for square in sorted(part) if square not in taken] if missing else []
    room = len(free) - (drawing.goal is None)  # one is left for the goal
    if missing > max(room, 0):
        raise ScenarioError(
            f"{source}: {wanted} agents, but {max(room, 0)} squares of floor are free for {missing} of them"
        )
    drawing.agents += draw_some(free, missing, seed)


def _farthest(drawing: Drawing, source: str) -> int:
    """The free square farthest from the first agent; of those behind holes, if there are any."""
    start = drawing.agents[0]
    here = _without_holes(drawing)
    for _ in drawing.layers(start, here):
        pass
    everywhere = drawing.walls() if drawing.boxes else _without_holes(drawing)
    taken, found = _taken(drawing), (False, -1, 0)
    for distance, layer in enumerate(drawing.layers(start, everywhere)):
        for square in layer:
            if square not in taken:
                found = max(found, (not here[square], distance, -square))
    if found[1] < 0:
        raise ScenarioError(f"{source}: no square of floor is free for the goal")
    return -found[2]


def _refuse_long(document: dict[str, Any], source: str) -> None:
    """Refuses a document that no scenario file may hold."""
    text = to_yaml(document)
    if len(text.encode()) > MAX_BYTES or text.count(",") + 3 * text.count("\n") > MAX_VALUES:
        raise ScenarioError(
            f"{source}: the scenario would be larger than a file may be, {MAX_BYTES / 1e6:g} MB and {MAX_VALUES}"
            " values; crop keeps a part: x0,y0,x1,y1"
        )
