"""Random plans of maps, written as each of the formats that `colonysim import` reads, and what must come of them.

A plan is a list of rows of characters: # wall, . floor, b box, h hole, a agent, g goal.
"""

from __future__ import annotations

import base64
import gzip
import json
import random
import struct
import zlib
from collections import deque
from typing import Any

import colonysim

Plan = list[str]


def reached(plan: Plan, start: tuple[int, int]) -> set[tuple[int, int]]:
    """The squares (column, row) that are joined with one."""
    seen, waiting = {start}, deque([start])
    while waiting:
        x, y = waiting.popleft()
        for i, j in ((x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)):
            if 0 <= j < len(plan) and 0 <= i < len(plan[0]) and plan[j][i] != "#" and (i, j) not in seen:
                seen.add((i, j))
                waiting.append((i, j))
    return seen


def squares(plan: Plan, kind: str) -> list[tuple[int, int]]:
    return [(x, y) for y, row in enumerate(plan) for x, character in enumerate(row) if character == kind]


def random_plan(seed: int, *, agents: int = 2, boxes: int = 3, holes: int = 2, goal: bool = True) -> Plan:
    """A plan walled all around, of whose largest part some squares have something on them."""
    rng = random.Random(seed)
    while True:
        columns, rows, dense = rng.randint(6, 20), rng.randint(6, 14), rng.uniform(0.05, 0.4)
        drawn = [["#" if rng.random() < dense else "." for _ in range(columns)] for _ in range(rows)]
        for y, row in enumerate(drawn):
            row[0] = row[-1] = "#"
            row[:] = "#" * columns if y in (0, rows - 1) else row
        plan = ["".join(row) for row in drawn]
        parts = [reached(plan, square) for square in squares(plan, ".")]
        room = sorted(max(parts, key=len, default=set()))
        wanted = "a" * agents + "b" * boxes + "h" * holes + "g" * goal
        if len(room) > len(wanted) + 3:
            for (x, y), kind in zip(rng.sample(room, len(wanted)), wanted, strict=True):
                drawn[y][x] = kind
            return ["".join(row) for row in drawn]


def check(document: dict[str, Any], plan: Plan, *, spacing: float = 1.0, diagonals: bool = False) -> None:
    """The part of the plan that holds its agents or goal is what the document describes, and nothing else is."""
    scenario = colonysim.scenario_from_document(document)
    place = scenario.topology
    held = [*squares(plan, "a"), *squares(plan, "g")]
    parts = [reached(plan, square) for square in (held or squares(plan, "."))]
    kept = max(parts, key=len)

    def point(square: tuple[int, int]) -> tuple[float, float]:
        return round(square[0] * spacing, 6), round((len(plan) - 1 - square[1]) * spacing, 6)

    at = list(zip(place.x, place.y, strict=True))
    assert set(at) == {point(square) for square in kept} and len(at) == len(kept)
    edges = set()
    for x, y in kept:
        edges |= {((x, y), other) for other in ((x + 1, y), (x, y + 1)) if other in kept}
        if diagonals:
            edges |= {((x, y), (x + 1, y + dy)) for dy in (-1, 1) if {(x + 1, y + dy), (x + 1, y), (x, y + dy)} <= kept}
    found = {frozenset((at[i], at[j])) for i in range(len(at)) for j in place.neighbours[i]}
    assert found == {frozenset((point(a), point(b))) for a, b in edges}

    def points(kind: str) -> list[tuple[float, float]]:
        return sorted(point(square) for square in squares(plan, kind) if square in kept)

    assert sorted(at[hole.node] for hole in scenario.holes) == points("h")
    assert sorted(at[box.node] for box in scenario.boxes) == points("b")
    assert set(points("a")) <= {at[agent] for agent in scenario.agents}
    assert not points("g") or at[scenario.goal] == points("g")[0]
    assert {hole.depth for hole in scenario.holes} <= {1.0} and {box.height for box in scenario.boxes} <= {1.0}


def movingai(plan: Plan, seed: int = 0) -> bytes:
    rng = random.Random(seed)
    rows = ["".join(rng.choice("@OTW" if square == "#" else ".GS") for square in row) for row in plan]
    end = rng.choice(("\n", "\r\n"))
    sizes = [f"height {len(plan)}", f"width {len(plan[0])}"]
    return end.join(["type octile", *sizes, "map", *rows, *([""] if rng.random() < 0.8 else [])]).encode()


SOKOBAN = {"#": "#", ".": " -_", "b": "$", "h": ".", "a": "@"}


def sokoban(plan: Plan, seed: int = 0) -> bytes:
    """One level, among lines of text, sometimes run-length encoded."""
    rng = random.Random(seed)
    rows = ["".join(rng.choice(SOKOBAN[square]) for square in row) for row in plan]
    if rng.random() < 0.3:
        rows = [encoded(row) for row in rows]
        if rng.random() < 0.5:
            rows = ["|".join(rows)]
    before = rng.choice(("", "; 1\n\n", "Title: Bob\n\n", ":: a # comment\n1\n"))
    return (before + "\n".join(rows) + rng.choice(("", "\n", "\nAuthor: me\n\nrrUUll\n"))).encode()


def encoded(row: str) -> str:
    found = ""
    at = 0
    while at < len(row):
        count = len(row[at:]) - len(row[at:].lstrip(row[at]))
        found += (str(count) if count > 1 else "") + row[at]
        at += count
    return found


COLOURS = {
    "#": (0, 0, 0), ".": (255, 255, 255), "b": (0, 0, 255), "h": (128, 128, 128), "a": (255, 0, 0), "g": (0, 255, 0),
}  # fmt: skip


def png(
    columns: int, rows: int, depth: int, kind: int, lines: list[bytes], *chunks: tuple[bytes, bytes], passes: int = 0
) -> bytes:
    """A PNG of any kind from its packed rows: what the format says, and no more."""

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    header = struct.pack(">IIBBBBB", columns, rows, depth, kind, 0, 0, passes)
    packed = zlib.compress(b"".join(b"\0" + line for line in lines))
    parts = [chunk(b"IHDR", header), *(chunk(*each) for each in chunks), chunk(b"IDAT", packed), chunk(b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


PNG_KINDS = ("rgb", "rgba", "rgb16", "rgba16", "palette1248", "palette-clear", "rgb-clear", "interlaced")
ADAM7 = ((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2))
GREY_KINDS = ("grey1", "grey2-clear", "grey8", "grey16", "grey-alpha", "grey16-alpha", "grey16-clear", "grey1-clear")


def bits(values: list[int], depth: int) -> bytes:
    """Values of `depth` bits each, packed into bytes from the left."""
    text = "".join(f"{value:0{depth}b}" for value in values)
    return bytes(int(text[at : at + 8].ljust(8, "0"), 2) for at in range(0, len(text), 8))


def picture(plan: Plan, kind: str) -> bytes:
    """A plan as a picture; `clear` ones have no wall, but nothing there, which means the same."""
    size = len(plan[0]), len(plan)
    colours = [[COLOURS[square] for square in row] for row in plan]
    if kind in ("rgb", "rgba"):
        alpha = b"\xff" if kind == "rgba" else b""
        return png(*size, 8, 6 if alpha else 2, [b"".join(bytes(c) + alpha for c in row) for row in colours])
    if kind in ("rgb16", "rgba16"):
        alpha = b"\xff\xff" if kind == "rgba16" else b""
        lines = [b"".join(bytes(v for c in colour for v in (c, c)) + alpha for colour in row) for row in colours]
        return png(*size, 16, 6 if alpha else 2, lines)
    if kind == "interlaced":
        parts = [b"".join(map(bytes, row[x::i])) for x, y, i, j in ADAM7 for row in colours[y::j]]
        return png(*size, 8, 2, [part for part in parts if part], passes=1)
    if kind == "rgb-clear":
        lines = [b"".join(bytes((9, 8, 7) if c == (0, 0, 0) else c) for c in row) for row in colours]
        return png(*size, 8, 2, lines, (b"tRNS", struct.pack(">HHH", 9, 8, 7)))
    used = list(COLOURS.values())
    indices = [[used.index(colour) for colour in row] for row in colours]
    palette = (b"PLTE", b"".join(map(bytes, used)))
    if kind == "palette-clear":
        used[0] = (3, 3, 3)
        return png(*size, 8, 3, [bytes(row) for row in indices], palette, (b"tRNS", b"\0"))
    if kind.startswith("palette"):
        depth = int(kind[-1]) if max(map(max, indices)) < 2 else 4
        return png(*size, depth, 3, [bits(row, depth) for row in indices], palette)
    greys = [[colour[0] for colour in row] for row in colours]
    return grey_picture(greys, kind)


def grey_picture(greys: list[list[int]], kind: str) -> bytes:
    """Shades from 0 to 255 as a picture that has only shades; those with `clear` have nothing where the shade is 0."""
    size = len(greys[0]), len(greys)
    clear = [(b"tRNS", b"\0\0")] if kind.endswith("clear") else []
    if kind.startswith("grey16"):
        wide = [[struct.pack(">H", 257 * grey) for grey in row] for row in greys]
        if kind == "grey16-alpha":
            return png(*size, 16, 4, [b"".join(grey + b"\xff\xff" for grey in row) for row in wide])
        return png(*size, 16, 0, [b"".join(row) for row in wide], *clear)
    if kind == "grey-alpha":
        return png(*size, 8, 4, [b"".join(bytes((grey, 255)) for grey in row) for row in greys])
    depth = int(kind[4])
    return png(*size, depth, 0, [bits([grey >> 8 - depth for grey in row], depth) for row in greys], *clear)


KINDS = {"#": "wall", ".": "floor", "b": "box", "h": "hole", "a": "agent", "g": "goal"}
TILED_FORMS = ("tiles", "layers", "objects", "base64", "zlib", "gzip", "flipped", "group")


def tiled(plan: Plan, form: str) -> dict[str, Any]:
    """A plan as a map of Tiled, its meaning in one of several places."""
    columns, rows = len(plan[0]), len(plan)
    ids = {kind: n for n, kind in enumerate(KINDS, 1)}
    data = [ids[square] for row in plan for square in row]
    tiles: list[dict[str, Any]] = [{"id": n - 1, "type": KINDS[kind]} for kind, n in ids.items()]
    layers: list[dict[str, Any]]
    base = {"type": "tilelayer", "width": columns, "height": rows, "x": 0, "y": 0, "opacity": 1, "visible": True}
    if form in ("layers", "group"):
        tiles = []
        layers = [
            base | {"name": f"{word.title()}s" if word != "box" else "Boxes",
                    "data": [7 if square == kind else 0 for row in plan for square in row]}
            for kind, word in KINDS.items()
        ]  # fmt: skip
        if form == "group":
            layers = [{"type": "group", "name": each["name"], "layers": [each | {"name": "x"}]} for each in layers]
    elif form == "objects":
        layers = [base | {"name": "Walls", "data": [1 if square == "#" else 0 for row in plan for square in row]}]
        things = [(kind, x, y) for kind in KINDS if kind not in "#." for x, y in squares(plan, kind)]
        points = [
            {"id": n, "name": KINDS[kind], "type": "", "point": True, "x": 16 * x + 8.5, "y": 16 * y + 3,
             "width": 0, "height": 0, "rotation": 0, "visible": True}
            for n, (kind, x, y) in enumerate(things)
        ]  # fmt: skip
        layers.append({"type": "objectgroup", "name": "things", "objects": points})
    else:
        layers = [base | {"name": "all", "data": data}]
        if form == "flipped":
            layers[0]["data"] = [gid | (n % 16) << 28 for n, gid in enumerate(data)]
        elif form != "tiles":
            raw = struct.pack(f"<{len(data)}I", *data)
            packed = {"base64": bytes, "zlib": zlib.compress, "gzip": gzip.compress}[form](raw)
            layers[0] |= {"encoding": "base64", "data": base64.b64encode(packed).decode()}
            layers[0] |= {} if form == "base64" else {"compression": form}
    return {
        "type": "map", "version": "1.10", "tiledversion": "1.11.0", "orientation": "orthogonal", "infinite": False,
        "renderorder": "right-down", "width": columns, "height": rows, "tilewidth": 16, "tileheight": 16,
        "tilesets": [{"firstgid": 1, "name": "kinds", "tilecount": 8, "columns": 4, "tiles": tiles}], "layers": layers,
    }  # fmt: skip


def tiled_file(plan: Plan, form: str) -> bytes:
    return json.dumps(tiled(plan, form)).encode()
