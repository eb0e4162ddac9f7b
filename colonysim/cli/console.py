"""Where words go: results to standard output, everything else to standard error; and none of them commands a terminal.

Names, reasons and paths come from files that somebody else may have written. Whatever is printed passes `visible`, on
its way through one of the functions below, so that no control character of theirs reaches a terminal.
"""

from __future__ import annotations

import json
import math
import sys
from typing import TYPE_CHECKING, Any

import typer

from colonysim.characters import COMMANDS, visible
from colonysim.terminal import error_console, on_terminal, say

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["error_console", "on_terminal", "print_json", "print_result", "print_table", "print_text", "say"]


def print_result(text: str) -> None:
    """A line on standard output."""
    typer.echo(visible(text))


def print_text(text: str) -> None:
    """A whole text on standard output: to a file or a pipe exactly as it is, on a terminal made visible."""
    sys.stdout.write(visible(text) if sys.stdout.isatty() else text)
    sys.stdout.flush()


def print_json(value: Any) -> None:
    """One JSON value on standard output, and nothing else; of a number that is not finite, null."""
    text = json.dumps(_for_json(value), indent=2, ensure_ascii=False, allow_nan=False)
    # JSON writes every one of them so that it means the same.
    typer.echo(COMMANDS.sub(lambda found: f"\\u{ord(found[0]):04x}", text))


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
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table(title=title and visible(title), box=box.SIMPLE_HEAD, title_justify="left", pad_edge=False)
    for name in columns:
        shown, right = visible(name.lstrip(">")), name.startswith(">")
        table.add_column(shown, justify="right" if right else "left", overflow="fold")
    for row in rows:
        table.add_row(*(visible(cell).replace("\n", "\\n") for cell in row))
    # A pipe has no width: lines must not be broken there.
    wide = None if sys.stdout.isatty() else 200
    console = Console(highlight=False, markup=False, emoji=False, width=wide)
    with console.capture() as captured:
        console.print(table)
    typer.echo("\n".join(line.rstrip() for line in captured.get().rstrip().splitlines()))
