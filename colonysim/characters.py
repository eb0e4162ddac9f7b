"""Characters that cannot be seen, or that command a terminal: written out before a text is shown."""

from __future__ import annotations

import re

__all__ = ["COMMANDS", "printable", "visible"]

# Control characters but for ends of lines and tabs, marks that turn or break a line, and halves of pairs, which is how
# Python keeps the bytes of a path that are no text.
COMMANDS = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff\ufeff\ufff9-\ufffb]"
)
"""Whatever a terminal might obey."""


def visible(text: str) -> str:
    r"""Text with its control characters written out, so that a name cannot move the cursor or colour the terminal.

    Example:
        >>> print(visible("a\x1b[2Jb"))
        a\x1b[2Jb
    """
    return COMMANDS.sub(lambda found: _written_out(found[0]), text)


def printable(text: str, most: int = 80) -> str:
    """A text for a message: control characters escaped, and cut to at most `most` characters.

    Other than in `visible`, ends of lines and whatever else is not printed go too: a message is one line.
    """
    short = text if len(text) <= most else f"{text[: most - 3]}..."
    return "".join(c if c.isprintable() else _written_out(c) for c in short)


def _written_out(character: str) -> str:
    return character.encode("unicode_escape").decode()
