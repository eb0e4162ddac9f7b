"""Reads maps of the Tiled editor in JSON (`.tmj`, `.json`): tile layers and objects that say what is where."""

from __future__ import annotations

import base64
import binascii
import math
import zlib
from bisect import bisect
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, Strict, ValidationError

from colonysim.arguments import real
from colonysim.characters import printable
from colonysim.errors import ColonysimError, ScenarioError
from colonysim.scenario.complaints import wrong_value
from colonysim.scenario.imports.drawing import KINDS, Drawing, Kind, check_size
from colonysim.scenario.invent import HEIGHT
from colonysim.scenario.sections import LARGEST, SMALLEST

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy as np
    from numpy.typing import NDArray

__all__ = ["read_tiled"]

IGNORE = "ignore"
_WORDS: dict[str, str] = {
    IGNORE: IGNORE, **{kind: kind for kind in KINDS}, **{f"{kind}s": kind for kind in KINDS}, "boxes": "box",
}  # fmt: skip
"""Names and classes that mean something."""
_EXPECTED = f"one of {', '.join(KINDS)} or {IGNORE} as the class of the tile, or the class or name of the layer"
_GID = 0x0FFFFFFF
"""The bits of a tile's number; the upper four say how it is turned."""

Whole = Annotated[int, Strict()]
Number = Annotated[float, Strict()]
Text = Annotated[str, Strict()]


class _Part(BaseModel):
    """A mapping in the file; fields that do not matter here are passed over."""

    model_config = ConfigDict(extra="ignore", frozen=True)


class _Property(_Part):
    name: Text
    value: Any = None


class _Named(_Part):
    """What can have a meaning of its own."""

    name: Text = ""
    type: Text = ""
    given: Text = Field("", alias="class")
    properties: list[_Property] = []

    def meaning(self) -> str | None:
        """Its class, else a property of that name that is true, else its own name."""
        told = [self.given, self.type, *(each.name for each in self.properties if each.value is True), self.name]
        return next((found for word in told if (found := _WORDS.get(word.strip().casefold()))), None)

    def size(self, name: str) -> float | None:
        """A property that is a length."""
        values = [each.value for each in self.properties if each.name.strip().casefold() == name]
        return real(name, values[0], SMALLEST, LARGEST) if values else None


class _Tile(_Named):
    id: Annotated[int, Strict(), Field(ge=0, le=_GID)]


class _Tileset(_Part):
    firstgid: Annotated[int, Strict(), Field(ge=1, le=_GID)]
    source: Text | None = None
    tilecount: Whole = 0
    columns: Whole = 0
    tiles: list[_Tile] = []


class _Object(_Named):
    id: Whole = 0
    x: Number = 0.0
    y: Number = 0.0
    width: Annotated[float, Strict(), Field(ge=0)] = 0.0
    height: Annotated[float, Strict(), Field(ge=0)] = 0.0
    rotation: Number = 0.0
    gid: Annotated[int, Strict(), Field(ge=1, le=2**32 - 1)] | None = None
    ellipse: Any = None
    capsule: Any = None
    polygon: Any = None
    polyline: Any = None
    text: Any = None
    template: Any = None


class _Layer(_Named):
    type: Literal["tilelayer", "objectgroup", "imagelayer", "group"]
    width: Whole | None = None
    height: Whole | None = None
    offsetx: Number = 0.0
    offsety: Number = 0.0
    encoding: Text = "csv"
    compression: Text = ""
    data: Any = None
    objects: list[_Object] = []
    layers: list[_Layer] = []


class _Map(_Part):
    orientation: Text
    infinite: Annotated[bool, Strict()] = False
    width: Annotated[int, Strict(), Field(ge=1, le=10**9)]
    height: Annotated[int, Strict(), Field(ge=1, le=10**9)]
    tilewidth: Annotated[int, Strict(), Field(ge=1, le=10**6)]
    tileheight: Annotated[int, Strict(), Field(ge=1, le=10**6)]
    layers: list[_Layer]
    tilesets: list[_Tileset] = []


def read_tiled(value: Any, source: str) -> Drawing:
    """Reads a map.

    Args:
        value: What the JSON file holds.
        source: Its name in messages.

    Raises:
        ScenarioError: It is no such map, or something in it has no meaning; the message names the field, or the layer
            and the square.
    """
    kind = value.get("type", "") if isinstance(value, dict) else ""
    if kind != "map":
        of = f", it is of the type '{printable(str(kind), 40)}'" if kind else ""
        raise ScenarioError(f"{source}: is no map of Tiled{of}; expected a mapping whose `type` is map")
    try:
        read = _Map.model_validate(value)
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        path = printable(".".join(map(str, fault["loc"])))
        wrong = "is missing, Tiled always writes it" if fault["type"] == "missing" else wrong_value(fault)
        raise ScenarioError(f"{source}: {path}: {wrong}") from None
    if read.orientation != "orthogonal":
        raise ScenarioError(
            f"{source}: orientation: a map that is {printable(read.orientation, 40)}, expected orthogonal"
        )
    if read.infinite:
        raise ScenarioError(
            f"{source}: infinite: the map has no size; in Tiled, Map > Map Properties > Infinite turns that off"
        )
    check_size(read.width, read.height, source)
    return _Reader(read, source).drawing()


class _Reader:
    """One pass over a map, layer by layer."""

    def __init__(self, read: _Map, source: str) -> None:
        self._map = read
        self._source = source
        self._tilesets = sorted(read.tilesets, key=lambda each: each.firstgid)
        self._starts = [each.firstgid for each in self._tilesets]
        self._tiles = [{tile.id: tile for tile in each.tiles} for each in self._tilesets]
        squares = read.width * read.height
        self._floor, self._walls = bytearray(squares), bytearray(squares)
        self._standing: list[tuple[Kind, int, float, str]] = []

    def drawing(self) -> Drawing:
        """The map as squares; where nothing is drawn as floor, every square without a wall is."""
        for layer in self._map.layers:
            self._layer(layer, None, ())
        drawn = any(self._floor)
        floor = bytearray(
            (not drawn or covered) and not wall for covered, wall in zip(self._floor, self._walls, strict=True)
        )
        found = Drawing(self._map.width, self._map.height, self._at, floor)
        for kind, square, size, place in self._standing:
            if self._walls[square]:
                raise ScenarioError(f"{place}: the {kind} stands on a wall, expected floor")
            found.put(kind, square, size)
        return found

    def _at(self, column: int, row: int) -> str:
        return f"{self._source}: square {column}, {row}"

    def _layer(self, layer: _Layer, inherited: str | None, above: tuple[_Layer, ...]) -> None:
        place = f"{self._source}: layer '{printable(layer.name, 40)}'"
        word = layer.meaning() or inherited
        if word == IGNORE or layer.type == "imagelayer":
            return
        if layer.offsetx or layer.offsety:
            raise ScenarioError(f"{place}: is moved by {layer.offsetx:g}, {layer.offsety:g} pixels, expected no offset")
        above = (layer, *above)
        for inner in layer.layers:
            self._layer(inner, word, above)
        if layer.type == "tilelayer":
            self._tile_layer(layer, place, word, above)
        for thing in layer.objects:
            self._object(thing, f"{place}, object {thing.id}", word, above)

    def _tile_layer(self, layer: _Layer, place: str, word: str | None, above: tuple[_Layer, ...]) -> None:
        import numpy as np

        columns, rows = self._map.width, self._map.height
        if (layer.width, layer.height) != (columns, rows):
            raise ScenarioError(f"{place}: {layer.width} x {layer.height} squares, expected {columns} x {rows}"
                                " as the map has")  # fmt: skip
        numbers = _numbers(layer, columns * rows, place) & _GID
        found, first, index = np.unique(numbers, return_index=True, return_inverse=True)
        wanted: list[tuple[int, str, float]] = []
        for n in np.argsort(first).tolist():
            if gid := int(found[n]):
                at = f"{place}, square {first[n] % columns}, {first[n] // columns}"
                tile, outside = self._tile(gid, at)
                kind = (tile.meaning() if tile else None) or word
                if kind is None:
                    why = f", as its tileset {outside} is a file of its own, which is not read" if outside else ""
                    raise ScenarioError(f"{at}: tile {gid} has no meaning{why}; expected {_EXPECTED}")
                wanted.append((n, kind, _size(kind, at, tile, *above)))
        for n, kind, size in wanted:
            for square in np.flatnonzero(index == n).tolist() if kind != IGNORE else ():
                self._draw(kind, square, size, self._at(square % columns, square // columns))

    def _tile(self, gid: int, place: str) -> tuple[_Tile | None, str]:
        """What a tileset says of a tile, if anything; and the tileset's file, if it has one of its own."""
        n = bisect(self._starts, gid) - 1
        tileset = self._tilesets[n] if n >= 0 else None
        # A tileset without columns is a collection of pictures, of which some may be missing.
        if tileset is None or (tileset.columns > 0 and gid - tileset.firstgid >= tileset.tilecount):
            known = f"{len(self._tilesets)} tileset{'s' * (len(self._tilesets) != 1)}"
            raise ScenarioError(f"{place}: there is no tile {gid} in the {known} of the map")
        return self._tiles[n].get(gid - tileset.firstgid), printable(tileset.source or "", 60)

    def _object(self, thing: _Object, place: str, word: str | None, above: tuple[_Layer, ...]) -> None:
        tile = self._tile(thing.gid & _GID, place)[0] if thing.gid is not None else None
        kind = thing.meaning() or (tile.meaning() if tile else None) or word
        if kind == IGNORE:
            return
        if kind is None:
            named = f"'{printable(thing.given or thing.type or thing.name, 40)}'"
            raise ScenarioError(f"{place}: {named} has no meaning, expected one of {', '.join(KINDS)} or {IGNORE}"
                                " as the class or name of the object or of its layer")  # fmt: skip
        for name in ("ellipse", "capsule", "polygon", "polyline", "text", "template"):
            if getattr(thing, name):
                raise ScenarioError(f"{place}: {name}: expected a rectangle, a point or a tile")
        if thing.rotation:
            raise ScenarioError(f"{place}: is turned by {thing.rotation:g} degrees, expected 0")
        size = _size(kind, place, thing, tile, *above)
        for square in self._covered(thing, place):
            self._draw(kind, square, size, place)

    def _covered(self, thing: _Object, place: str) -> Iterator[int]:
        """The squares whose centre lies in an object; if there are none, the one that its own centre lies in."""
        across, down = self._map.tilewidth, self._map.tileheight
        columns, rows = self._map.width, self._map.height
        try:
            left, width = (real(name, getattr(thing, name), -LARGEST, LARGEST) for name in ("x", "width"))
            top, height = (real(name, getattr(thing, name), -LARGEST, LARGEST) for name in ("y", "height"))
        except ColonysimError as error:
            raise ScenarioError(f"{place}: {error}") from None
        top -= height if thing.gid is not None else 0.0  # tiles hang from their lower left corner
        xs = range(max(0, math.ceil(left / across - 0.5)), min(columns, math.ceil((left + width) / across - 0.5)))
        ys = range(max(0, math.ceil(top / down - 0.5)), min(rows, math.ceil((top + height) / down - 0.5)))
        if xs and ys:
            yield from (y * columns + x for y in ys for x in xs)
            return
        x, y = math.floor((left + width / 2) / across), math.floor((top + height / 2) / down)
        if not (0 <= x < columns and 0 <= y < rows):
            raise ScenarioError(f"{place}: lies outside the map of {columns} x {rows} squares")
        yield y * columns + x

    def _draw(self, kind: str, square: int, size: float, place: str) -> None:
        if kind == "wall":
            self._walls[square] = 1
        elif kind == "floor":
            self._floor[square] = 1
        else:
            self._standing.append((next(each for each in KINDS if each == kind), square, size, place))


def _size(kind: str, place: str, *said: _Named | None) -> float:
    """The height of a box or the depth of a hole, as the first that says so has it, graph units."""
    name = {"box": "height", "hole": "depth"}.get(kind)
    try:
        sizes = [each.size(name) for each in said if each is not None] if name else []
    except ColonysimError as error:
        raise ScenarioError(f"{place}: {error}") from None
    return next((size for size in sizes if size is not None), HEIGHT)


def _numbers(layer: _Layer, count: int, place: str) -> NDArray[np.uint32]:
    """The numbers of the tiles of a layer, the bits that say how they are turned included."""
    import numpy as np

    data: Any = layer.data
    if layer.encoding == "csv" and isinstance(data, list):
        _check_count(len(data), count, place)
        wrong = next((n for n, gid in enumerate(data) if type(gid) is not int or not 0 <= gid < 2**32), None)
        if wrong is not None:
            raise ScenarioError(f"{place}: data.{wrong}: expected the number of a tile, 0 to {2**32 - 1}")
        return np.array(data, dtype=np.uint32)
    if layer.encoding != "base64" or not isinstance(data, str):
        raise ScenarioError(f"{place}: data: expected a list of numbers, or text with the encoding base64")
    try:
        packed = base64.b64decode(data.strip(), validate=True)
        if layer.compression in _UNPACKED:
            unpacker = zlib.decompressobj(_UNPACKED[layer.compression])
            # Bounded: a few bytes may stand for gigabytes.
            packed = unpacker.decompress(packed, 4 * count + 1)
        elif layer.compression:
            raise ScenarioError(f"{place}: compression: '{printable(layer.compression, 20)}', expected none,"
                                f" {' or '.join(_UNPACKED)}")  # fmt: skip
    except (binascii.Error, ValueError, zlib.error) as error:
        raise ScenarioError(f"{place}: data: cannot be unpacked: {printable(str(error))}") from None
    if len(packed) != 4 * count:
        more = "more than" if len(packed) > 4 * count else f"{len(packed)} bytes instead of"
        raise ScenarioError(f"{place}: data: {more} the {4 * count} bytes of {count} squares")
    return np.frombuffer(packed, dtype="<u4").astype(np.uint32)


_UNPACKED = {"zlib": zlib.MAX_WBITS, "gzip": zlib.MAX_WBITS + 16}


def _check_count(found: int, count: int, place: str) -> None:
    if found != count:
        raise ScenarioError(f"{place}: data: {found} tiles, expected {count}, one for each square")
