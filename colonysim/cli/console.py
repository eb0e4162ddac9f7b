"""Where words go: results to standard output, everything else to standard error; and none of them commands a terminal.

Names, reasons and paths come from files that somebody else may have written. Whatever is printed passes `plain`, on
its way through one of the functions below, so that no control character of theirs reaches a terminal.
"""

from __future__ import annotations

import json
import math
import re
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.console import Console

__all__ = ["echo", "error_console", "plain", "print_json", "print_table", "say"]

_COMMANDS = re.compile(
    # Control characters but tab and line feed, lone surrogates, and what turns the direction of writing.
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff\ufeff\ufff9-\ufffb]"
)


def plain(text: str) -> str:
    r"""A text whose control characters are written out, such as `\x1b`, instead of commanding a terminal."""
    return _COMMANDS.sub(lambda found: ascii(found[0])[1:-1], text)


def error_console() -> Console:
    """A console on standard error, for texts that have passed `plain`; it takes nothing in them for markup."""
    from rich.console import Console

    return Console(stderr=True, highlight=False, markup=False, emoji=False)


def echo(text: str) -> None:
    """A line on standard output."""
    typer.echo(plain(text))


def say(text: str) -> None:
    """A line on standard error."""
    typer.echo(plain(text), err=True)


def print_json(value: Any) -> None:
    """One JSON value on standard output, and nothing else; of a number that is not finite, null."""
    text = json.dumps(_for_json(value), indent=2, ensure_ascii=False, allow_nan=False)
    # JSON writes every one of them so that it means the same.
    typer.echo(_COMMANDS.sub(lambda found: f"\\u{ord(found[0]):04x}", text))


def _for_json(value: Any) -> Any:
    """The same in types that JSON knows: dates and the like as text, decimals as numbers."""
    from decimal import Decimal

    if isinstance(value, Decimal):
        value = int(value) if value.is_finite() and value == value.to_integral_value() else float(value)
    if value is None or isinstance(value, (str, bool, int)):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {str(key): _for_json(item) for key, item in value.items()}
    if isinstance(value, (list, tuple, set, frozenset)):
        return [_for_json(item) for item in value]
    return value.hex() if isinstance(value, bytes) else str(value)


def print_table(columns: Sequence[str], rows: Sequence[Sequence[str]], title: str | None = None) -> None:
    """A table on standard output; columns whose name starts with ">" are aligned to the right."""
    import sys

    from rich import box
    from rich.console import Console
    from rich.table import Table

    named = None if title is None else plain(title)
    table = Table(title=named, box=box.SIMPLE_HEAD, title_justify="left", pad_edge=False)
    for name in map(plain, columns):
        table.add_column(name.lstrip(">"), justify="right" if name.startswith(">") else "left", overflow="fold")
    for row in rows:
        table.add_row(*(plain(cell).replace("\n", "\\n") for cell in row))
    # A pipe has no width: lines must not be broken there.
    wide = None if sys.stdout.isatty() else 200
    console = Console(highlight=False, markup=False, emoji=False, width=wide)
    with console.capture() as captured:
        console.print(table)
    typer.echo("\n".join(line.rstrip() for line in captured.get().rstrip().splitlines()))
