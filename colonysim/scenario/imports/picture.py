"""Reads pictures (`.png`): a square for each pixel, and its colour says what is there."""

from __future__ import annotations

import io
import re
import struct
import zlib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from colonysim.arguments import shown, whole
from colonysim.characters import printable
from colonysim.errors import ColonysimError, MissingExtraError, ScenarioError
from colonysim.installing import install_command
from colonysim.scenario.imports.drawing import KINDS, Drawing, Kind, check_size
from colonysim.suggest import nearest

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ["LEGEND", "read_picture"]

TRANSPARENT = "transparent"
LEGEND: dict[str, Kind] = {
    "#000000": "wall",
    "#ffffff": "floor",
    "#0000ff": "box",
    "#808080": "hole",
    "#ff0000": "agent",
    "#00ff00": "goal",
    TRANSPARENT: "wall",
}
"""What a colour means unless it is said otherwise."""
_COLOUR = re.compile(r"#[0-9a-f]{6}")
_SIGNATURE = b"\x89PNG\r\n\x1a\n"


def read_picture(
    data: bytes, source: str, colours: Mapping[str, str] | None = None, tolerance: int = 0
) -> Drawing:
    """Reads a picture.

    Args:
        data: The file's content.
        source: Its name in messages.
        colours: Meanings of further colours, or other ones: {"#c0c0c0": "floor", "transparent": "floor"}.
        tolerance: How much red, green and blue of a pixel may each differ from a colour that has a meaning, of 255;
            the nearest one counts. So much may the opacity of a pixel differ from none or full.

    Raises:
        ScenarioError: It is no such picture, or has a pixel without a meaning; the message names the pixel.
        ColonysimError: `colours` or `tolerance` is wrong.
        MissingExtraError: Pillow is not installed.
    """
    legend = _legend(colours or {})
    tolerance = whole("tolerance", tolerance, 0, 255)
    pixels = _pixels(data, source)
    rows, columns = pixels.shape

    def at(column: int, row: int) -> str:
        return f"{source}: pixel {column}, {row}"

    import numpy as np

    found, first, index = np.unique(pixels, return_index=True, return_inverse=True)
    meanings: list[Kind | None] = []
    troubles = []
    for colour, where in zip(found.tolist(), first.tolist(), strict=True):
        meaning = _meaning(colour, legend, tolerance)
        meanings.append(meaning if meaning in KINDS else None)
        if meaning not in KINDS:
            troubles.append((where, meaning))
    if troubles:
        where, trouble = min(troubles)
        raise ScenarioError(f"{at(where % columns, where // columns)}: {trouble}")
    kinds = np.array([KINDS.index(meaning) for meaning in meanings if meaning], dtype=np.uint8)[index.reshape(-1)]
    drawing = Drawing(columns, rows, at, bytearray((kinds != KINDS.index("wall")).astype(np.uint8).tobytes()))
    for square in np.flatnonzero(kinds > KINDS.index("floor")).tolist():
        drawing.put(KINDS[kinds[square]], square)
    return drawing


def _legend(colours: Mapping[str, str]) -> dict[str, Kind]:
    """What each colour means, by its name in small letters."""
    legend = dict(LEGEND)
    if not isinstance(colours, Mapping):
        raise ColonysimError(f"colours: {shown(colours)}, expected a mapping from colours to meanings")
    for name, meaning in colours.items():
        colour = str(name).strip().lower()
        if colour != TRANSPARENT and not _COLOUR.fullmatch(colour):
            raise ColonysimError(f"colours: '{printable(str(name))}' is no colour, expected one such as #c0c0c0,"
                                 f" or {TRANSPARENT}")  # fmt: skip
        kind = next((kind for kind in KINDS if kind == meaning), None)
        if kind is None:
            raise ColonysimError(f"colours: {colour} cannot mean '{printable(str(meaning))}';"
                                 f" {nearest(str(meaning), KINDS)}")  # fmt: skip
        legend[colour] = kind
    return legend


def _meaning(colour: int, legend: Mapping[str, Kind], tolerance: int) -> str:
    """What a pixel means, or why it means nothing.

    Args:
        colour: Red, green, blue and opacity, a byte each, from the highest.
        legend: What each colour means.
        tolerance: How much each of them may differ.
    """
    red, green, blue, opacity = colour.to_bytes(4)
    name = f"#{red:02x}{green:02x}{blue:02x}"
    if opacity <= tolerance and opacity < 255 - opacity:
        return legend[TRANSPARENT]
    if opacity < 255 - tolerance:
        return f"the colour {name} with an opacity of {opacity} of 255, expected 0 or 255"
    near: dict[int, dict[Kind, str]] = {}
    for known, kind in legend.items():
        if known != TRANSPARENT:
            parts = bytes.fromhex(known[1:])
            apart = max(abs(a - b) for a, b in zip(parts, (red, green, blue), strict=True))
            near.setdefault(apart, {}).setdefault(kind, known)
    nearest_kinds = near[min(near)]
    kind, known = next(iter(nearest_kinds.items()))
    if min(near) > tolerance:
        return f"the colour {name} has no meaning, the nearest that has one is {known} ({kind}), {min(near)} away"
    if len(nearest_kinds) > 1:
        both = " and ".join(f"{known} ({kind})" for kind, known in nearest_kinds.items())
        return f"the colour {name} is as near to {both}; expected a smaller tolerance than {tolerance}"
    return kind


def _pixels(data: bytes, source: str) -> NDArray[np.uint32]:
    """Red, green, blue and opacity of each pixel, a byte each, from the highest; shape (rows, columns)."""
    try:
        from PIL import Image
    except ImportError as error:
        raise MissingExtraError(f"a picture as a map needs Pillow ({error}): {install_command('maps')}") from error
    if not data.startswith(_SIGNATURE):
        raise ScenarioError(f"{source}: is no PNG picture, whose first bytes are another's")
    if len(data) < 33 or data[12:16] != b"IHDR":
        raise ScenarioError(f"{source}: the picture is cut off or damaged: its header is missing")
    columns, rows = struct.unpack(">II", data[16:24])
    # Before Pillow sees it, which warns of large pictures and refuses only the largest.
    check_size(columns, rows, source)
    try:
        with Image.open(io.BytesIO(data), formats=("PNG",)) as image:
            image.verify()  # the checksums, and that it has an end
        _check_rows(data, columns, rows)
        with Image.open(io.BytesIO(data), formats=("PNG",)) as image:
            image.load()
            return _packed(image, data[24])
    except (OSError, SyntaxError, ValueError, EOFError, IndexError, KeyError, struct.error, zlib.error) as error:
        told = printable(str(error) or type(error).__name__)
        raise ScenarioError(f"{source}: the picture is cut off or damaged: {told}") from None


def _check_rows(data: bytes, columns: int, rows: int) -> None:
    """Refuses a picture with fewer pixels than its header says: Pillow would take those that are missing for black.

    Raises:
        ValueError: Pixels are missing.
    """
    bits, kind, interlaced = data[24], data[25], data[28]
    width = bits * {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}[kind]
    needed = 0
    for x, y, across, down in _PASSES if interlaced else ((0, 0, 1, 1),):
        some, lines = -((x - columns) // across), -((y - rows) // down)
        needed += lines * (1 + (some * width + 7) // 8) if some > 0 < lines else 0
    unpacker, found, at = zlib.decompressobj(), 0, 8
    while at < len(data) and found < needed:
        (length,) = struct.unpack(">I", data[at : at + 4])
        if data[at + 4 : at + 8] == b"IDAT":
            # Bounded: a few bytes may stand for gigabytes.
            found += len(unpacker.decompress(data[at + 8 : at + 8 + length], needed + 1))
        at += 12 + length
    if found < needed:
        raise ValueError("pixels are missing")


_PASSES = ((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2))
"""First column and row, and steps along both, of the seven parts in which an interlaced picture is kept."""


def _packed(image: Any, bits: int) -> NDArray[np.uint32]:
    """The pixels of a picture of any kind; of 16 bits a channel the upper 8 count.

    Args:
        image: A picture of Pillow's.
        bits: Of a channel in the file.
    """
    import numpy as np

    clear = image.info.get("transparency")
    if image.mode.startswith("I"):  # 16 bits of grey, which Pillow would cut off at 255 instead of scaling them
        deep = np.asarray(image).astype(np.uint32)
        opacity = np.where(deep == clear, 0, 255) if isinstance(clear, int) else np.full_like(deep, 255)
        channels = np.stack([deep >> 8] * 3 + [opacity], axis=2)
    else:
        # Pillow has made bytes of the pixels, and left most colours that stand for nothing as they are in the file.
        if isinstance(clear, tuple) and bits == 16:
            image.info["transparency"] = tuple(value >> 8 for value in clear)
        elif isinstance(clear, int) and bits < 8 and image.mode != "P":
            image = image.convert("L")
            image.info["transparency"] = min(clear, 2**bits - 1) * 255 // (2**bits - 1)
        channels = np.asarray(image.convert("RGBA"))
    packed: NDArray[np.uint32] = np.ascontiguousarray(channels, dtype=np.uint8).view(">u4")[..., 0]
    return packed
