"""Lists of numbers as people type them."""

from __future__ import annotations

import re

import typer

from colonysim.errors import ColonysimError

__all__ = ["read_duration", "read_numbers", "read_row", "read_span"]


def read_numbers(text: str) -> tuple[int, ...]:
    """Reads "1,3,10" and "1-5,8".

    Raises:
        typer.BadParameter: It is neither.
    """
    numbers: list[int] = []
    for part in text.split(","):
        match = re.fullmatch(r"\s*([0-9]{1,9})\s*(?:-\s*([0-9]{1,9})\s*)?", part)
        first, last = (int(match[1]), int(match[2] or match[1])) if match else (1, 0)
        if not 0 <= last - first < 100_000:
            raise typer.BadParameter(f"{text[:40]!r} is no list of numbers; expected one such as 1,3,10 or 1-5")
        numbers.extend(range(first, last + 1))
    return tuple(dict.fromkeys(numbers))


def read_duration(option: str, text: str) -> float:
    """Reads "60s", "1.5m", "2h" or a number of seconds, in seconds.

    Raises:
        ColonysimError: It is none of them, or no time at all.
    """
    match = re.fullmatch(r"\s*([0-9]{1,9}(?:\.[0-9]{1,9})?)\s*([smh]?)\s*", text)
    seconds = float(match[1]) * {"": 1.0, "s": 1.0, "m": 60.0, "h": 3600.0}[match[2]] if match else 0.0
    if seconds <= 0.0:
        raise ColonysimError(f"{option} {text[:40]}: expected a time such as 60s, 5m or 2h")
    return seconds


def read_span(text: str | None) -> tuple[int, int] | None:
    """Reads `11-20`, or one number, as first and last; None for nothing.

    Raises:
        ColonysimError: It is neither.
    """
    if text is None:
        return None
    match = re.fullmatch(r"\s*([0-9]{1,9})\s*(?:-\s*([0-9]{1,9})\s*)?", text)
    first, last = (int(match[1]), int(match[2] or match[1])) if match else (1, 0)
    if last < first:
        raise ColonysimError(f"--episodes {text[:40]}: expected a number, or two such as 11-20")
    return first, last


def read_row(option: str, text: str, example: str) -> tuple[int, ...]:
    """Reads whole numbers from 0 between commas, as many as an example has, such as "3,10".

    Raises:
        ColonysimError: There are more or fewer of them, or other things.
    """
    parts = [part.strip() for part in text.split(",")]
    if len(parts) != len(example.split(",")) or not all(re.fullmatch("[0-9]{1,9}", part) for part in parts):
        raise ColonysimError(f"{option} {text[:40]}: expected {example}")
    return tuple(int(part) for part in parts)
