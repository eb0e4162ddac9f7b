"""Reads YAML into plain data, and remembers where each field stands.

The reader works on the parser's events, not on objects: nothing in a file can create anything but
mappings, lists, text, numbers, true, false and null (the core schema of YAML 1.2, so that `no` is a
word and `1e3` a number), and every limit is checked before memory is spent.
"""

from __future__ import annotations

import copy
import math
import re
import sys
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from colonysim.characters import printable
from colonysim.errors import ScenarioError

__all__ = [
    "MAX_BYTES", "MAX_DEPTH", "MAX_DIGITS", "MAX_EXPANDED", "MAX_PATH", "MAX_VALUES", "control_character", "is_stream",
    "read_file", "read_text",
]  # fmt: skip

MAX_BYTES = 16_000_000
"""Largest file that is read; 100,000 listed nodes with their edges take about 6 MB."""
MAX_VALUES = 2_000_000
"""Most values in a file, aliases expanded."""
MAX_EXPANDED = 10_000
"""Most values that aliases (`*name`) may stand for, all together."""
MAX_DEPTH = 32
"""Deepest nesting of lists and mappings."""
MAX_DIGITS = 18
"""Most digits of a whole number."""
MAX_PATH = 300
"""Longest dotted path of a field: each value keeps its own, so that long names multiply with the number of values."""

_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_CHARACTERS = 64  # of a text that count as one value
_MAX_FLOAT = 400  # characters of a number with a point or an exponent
# What cannot be seen, what reorders the line it stands in, and lone halves of UTF-16 pairs, which cannot be written.
_CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069\ud800-\udfff]")
_INTEGER = re.compile(r"[-+]?[0-9]+\Z")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?\Z")
_NOT_FINITE = re.compile(r"([-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN))\Z")
_WORDS: dict[str, bool | None] = {"": None, "~": None, "null": None, "Null": None, "NULL": None}
_WORDS |= {"true": True, "True": True, "TRUE": True, "false": False, "False": False, "FALSE": False}
_CORE = "tag:yaml.org,2002:"
_TAGGED: dict[str, tuple[type, ...]] = {
    "str": (str,), "int": (int,), "float": (float, int), "bool": (bool,), "null": (type(None),),
}  # fmt: skip


def control_character(text: str, *, in_name: bool = False) -> str:
    """The first character of a text that no scenario may hold, as "U+001B"; empty if there is none.

    Args:
        text: A value, or a name.
        in_name: Whether it is the name of something: then it may hold no line break and no tab either.
    """
    if text.isprintable():
        return ""
    found = _CONTROL.search(text) or (in_name and re.search(r"[\t\n]", text))
    return f"U+{ord(found[0]):04X}" if found else ""


def is_stream(path: Path) -> bool:
    """Whether a path is standard input ("-"), a pipe or a terminal: what can be read once, and only to its end."""
    try:
        return str(path) == "-" or path.is_fifo() or path.is_char_device()
    except OSError:  # a name that is too long, a folder that may not be read
        return False


def read_file(path: Path, source: str, *, streams: bool = False) -> tuple[Any, dict[str, tuple[int, int]]]:
    """Reads a YAML file as plain data.

    Args:
        path: The file.
        source: Its name in messages.
        streams: Whether it may be a stream, too; see `is_stream`.

    Returns:
        The plain data, and line and column (from 1) of each field by dotted path.

    Raises:
        ScenarioError: The file is missing, too large, not UTF-8, or no YAML that a scenario may hold.
    """
    try:
        if streams and is_stream(path):
            if sys.stdin is None and str(path) == "-":
                raise ScenarioError(f"{source}: is closed, expected a scenario")
            with nullcontext(sys.stdin.buffer) if str(path) == "-" else path.open("rb") as stream:
                data = stream.read(MAX_BYTES + 1)
            size = len(data)
        elif path.is_dir():
            raise ScenarioError(f"{source}: is a directory, expected a YAML file")
        elif not path.is_file():
            raise ScenarioError(f"{source}: {'is no file' if path.exists() else 'no such file'}")
        else:
            size = path.stat().st_size
            with path.open("rb") as file:
                data = file.read(MAX_BYTES)
        if size > MAX_BYTES:
            raise ScenarioError(
                f"{source}: the file holds {size / 1e6:.1f} MB, expected at most {MAX_BYTES / 1e6:.0f} MB;"
                " a large regular place can be generated with `topology:`"
            )
    except OSError as error:
        raise ScenarioError(f"{source}: cannot be read: {error.strerror or error}") from None
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        column = error.start - data.rfind(b"\n", 0, error.start)
        byte = data[error.start]
        raise ScenarioError(f"{source}:{line}:{column}: byte 0x{byte:02x} is not UTF-8, expected UTF-8 text") from None
    return read_text(text, source)


def read_text(text: str, source: str, *, places: bool = True) -> tuple[Any, dict[str, tuple[int, int]]]:
    """Reads YAML text as plain data.

    Args:
        text: One YAML document.
        source: Its name in messages.
        places: Whether messages name line and column; not useful for the value of a command-line option.

    Returns:
        The plain data (None for an empty text), and line and column (from 1) of each field by dotted path.

    Raises:
        ScenarioError: The text is no YAML, or holds what a scenario may not hold.
    """
    reader = _Reader(text, source, places)
    try:
        for event in yaml.parse(text, _LOADER):
            reader.take(event)
    except yaml.MarkedYAMLError as error:
        raise reader.broken(error) from None
    except yaml.reader.ReaderError as error:
        code = error.character if isinstance(error.character, int) else ord(error.character)
        raise reader.unprintable(chr(code)) from None
    except UnicodeEncodeError as error:  # the parser written in C reads UTF-8
        raise reader.unprintable(error.object[error.start]) from None
    except ValueError:  # of the parser written in Python: an escape beyond the last character there is
        raise ScenarioError(f"{source}: an escape stands for no character") from None
    return reader.value, reader.positions


@dataclass(slots=True)
class _Frame:
    """A list or mapping that is being read."""

    value: Any
    path: str
    anchor: str | None
    started: int
    deep: int = 1
    key: str | None = None
    lines: dict[str, int] = field(default_factory=dict)


class _Reader:
    """Builds plain data from parser events, within the limits."""

    def __init__(self, text: str, source: str, places: bool) -> None:
        self.value: Any = None
        self.positions: dict[str, tuple[int, int]] = {}
        self._text = text
        self._source = source
        self._places = places
        self._frames: list[_Frame] = []
        self._anchors: dict[str, tuple[Any, int, int]] = {}  # value, size, depth
        self._values = 0
        self._expanded = 0
        self._documents = 0
        self._taken = 0

    def take(self, event: Any) -> None:
        """Takes the next event."""
        kind = type(event)
        self._taken = event.end_mark.index
        if kind is yaml.ScalarEvent:
            self._scalar(event)
        elif kind is yaml.SequenceStartEvent or kind is yaml.MappingStartEvent:
            self._open(event)
        elif kind is yaml.SequenceEndEvent or kind is yaml.MappingEndEvent:
            frame = self._frames.pop()
            self._deepen(frame.deep)
            if frame.anchor:
                self._anchors[frame.anchor] = (frame.value, self._values - frame.started, frame.deep)
        elif kind is yaml.AliasEvent:
            self._alias(event)
        elif kind is yaml.DocumentStartEvent:
            self._documents += 1
            if self._documents > 1:
                raise self._fault(event, "a second document starts here, expected one scenario per file")

    def broken(self, error: yaml.MarkedYAMLError) -> ScenarioError:
        """The message for text that the parser refuses."""
        problem = error.problem or error.context or "no YAML"
        mark = error.problem_mark or error.context_mark
        line, column = (mark.line, mark.column) if mark else (0, 0)
        # The parser reads ahead of its events, and gives up at a depth of its own.
        ahead = self._text[self._taken : mark.index if mark else None]
        if len(self._frames) + sum(map(ahead.count, "[{")) - sum(map(ahead.count, "]}")) > MAX_DEPTH:
            return ScenarioError(f"{self._at(line, column)}: nested deeper than {MAX_DEPTH} levels")
        lines = self._text.splitlines()
        if line < len(lines) and "\t" in lines[line][: column + 1]:
            problem += " (YAML is indented with spaces, not tabs)"
        elif error.context and error.context != problem:
            problem += f" ({error.context})"
        return ScenarioError(f"{self._at(line, column)}: {problem}")

    def unprintable(self, character: str) -> ScenarioError:
        """The message for a character that YAML does not allow."""
        start = max(self._text.find(character), 0)
        line, column = self._text.count("\n", 0, start), start - self._text.rfind("\n", 0, start) - 1
        at = self._at(line, column)
        return ScenarioError(f"{at}: the control character 0x{ord(character):02x} is not allowed")

    def _at(self, line: int, column: int) -> str:
        return f"{self._source}:{line + 1}:{column + 1}" if self._places else self._source

    def _fault(self, event: Any, message: str, path: str = "") -> ScenarioError:
        at, path = self._at(event.start_mark.line, event.start_mark.column), printable(path)
        return ScenarioError(f"{at}: {path}: {message}" if path else f"{at}: {message}")

    def _scalar(self, event: Any) -> None:
        frame = self._frames[-1] if self._frames else None
        if frame is not None and frame.key is None and type(frame.value) is dict:
            self._key(frame, event)
            return
        path = self._next_path()
        value = self._resolve(event, path)
        size = 1 + len(event.value) // _CHARACTERS
        self._put(event, path, value, size)
        if event.anchor:
            self._anchors[event.anchor] = (value, size, 0)

    def _key(self, frame: _Frame, event: Any) -> None:
        name = event.value
        mark = event.start_mark
        path = f"{frame.path}.{name}" if frame.path else name
        if control := control_character(name, in_name=True):
            raise self._fault(event, f"the character {control} is not allowed in a name", path)
        if len(path) > MAX_PATH:
            raise self._fault(event, f"a field's name and those it stands under are {len(path)} characters long,"
                              f" expected at most {MAX_PATH}", path)  # fmt: skip
        if name in frame.lines:
            raise self._fault(event, f"the key '{name}' stands twice, first on line {frame.lines[name]}", path)
        frame.lines[name] = mark.line + 1
        frame.key = name
        self.positions[path] = (mark.line + 1, mark.column + 1)

    def _open(self, event: Any) -> None:
        path = self._next_path()
        if event.tag and event.tag not in ("!", _CORE + "map", _CORE + "seq"):
            raise self._fault(event, f"the tag {_shown_tag(event.tag)} is not allowed, expected plain data", path)
        if len(self._frames) >= MAX_DEPTH:
            raise self._fault(event, f"nested deeper than {MAX_DEPTH} levels", path)
        value: Any = {} if isinstance(event, yaml.MappingStartEvent) else []
        self._put(event, path, value, 1)
        self._frames.append(_Frame(value, path, event.anchor, self._values - 1))

    def _alias(self, event: Any) -> None:
        path = self._next_path()
        if event.anchor not in self._anchors:
            name = printable(event.anchor)
            raise self._fault(event, f"the alias *{name} stands inside or before its own anchor", path)
        value, size, deep = self._anchors[event.anchor]
        if len(self._frames) + deep > MAX_DEPTH:
            raise self._fault(event, f"nested deeper than {MAX_DEPTH} levels", path)
        self._deepen(deep)
        self._expanded += size
        if self._expanded > MAX_EXPANDED:
            raise self._fault(event, f"aliases stand for more than {MAX_EXPANDED} values", path)
        self._put(event, path, copy.deepcopy(value), size)

    def _deepen(self, deep: int) -> None:
        """Something `deep` levels deep stands in the innermost list or mapping."""
        if self._frames:
            self._frames[-1].deep = max(self._frames[-1].deep, deep + 1)

    def _next_path(self) -> str:
        if not self._frames:
            return ""
        frame = self._frames[-1]
        key = frame.key if type(frame.value) is dict else str(len(frame.value))
        return f"{frame.path}.{key}" if frame.path else str(key)

    def _put(self, event: Any, path: str, value: Any, size: int) -> None:
        self._values += size
        if self._values > MAX_VALUES:
            raise self._fault(event, f"the file holds more than {MAX_VALUES} values")
        if not self._frames:
            self.value = value
            return
        frame = self._frames[-1]
        into = frame.value
        if type(into) is dict:
            if frame.key is None:
                raise self._fault(event, "a list or mapping stands where a key was expected", frame.path)
            into[frame.key] = value
            frame.key = None
        else:
            into.append(value)
            mark = event.start_mark
            self.positions[path] = (mark.line + 1, mark.column + 1)

    def _resolve(self, event: Any, path: str) -> Any:
        text = event.value
        if control := control_character(text):
            raise self._fault(event, f"the character {control} is not allowed", path)
        if event.tag == "!" or (event.tag is None and not event.implicit[0]):
            return text
        if event.tag is None:
            return self._plain(event, text, path)
        kind = event.tag.removeprefix(_CORE)
        if kind not in _TAGGED:
            raise self._fault(event, f"the tag {_shown_tag(event.tag)} is not allowed, expected plain data", path)
        value = text if kind == "str" else self._plain(event, text, path)
        if type(value) not in _TAGGED[kind]:
            raise self._fault(event, f"'{printable(text)}' is no !!{kind}", path)
        return value

    def _plain(self, event: Any, text: str, path: str) -> Any:
        if len(text) <= MAX_DIGITS and text.isdecimal() and text.isascii():  # most values of a large file
            return int(text)
        if _INTEGER.match(text):
            if len(text) > MAX_DIGITS:
                shown = f"{text[:20]}..."
                raise self._fault(event, f"{shown} is out of range, expected at most {MAX_DIGITS} digits", path)
            return int(text)
        if _FLOAT.match(text):
            if len(text) > _MAX_FLOAT:
                raise self._fault(event, f"{text[:20]}... has more than {_MAX_FLOAT} characters", path)
            number = float(text)
            if math.isinf(number):
                raise self._fault(event, f"{text[:20]} is out of range, expected a finite number", path)
            return number
        if _NOT_FINITE.match(text):
            raise self._fault(event, f"{text} is not allowed, expected a finite number", path)
        return _WORDS.get(text, text)


def _shown_tag(tag: str) -> str:
    tag = printable(tag)
    return f"!!{tag.removeprefix(_CORE)}" if tag.startswith(_CORE) else tag
