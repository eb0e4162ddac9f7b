"""The nearest right word for a wrong one."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

__all__ = ["nearest"]


def nearest(word: str, known: Iterable[str]) -> str:
    """A hint for a message: the known word that comes nearest, or all of them.

    Example:
        >>> nearest("bulet", ["nodeworld", "bullet"])
        "did you mean 'bullet'?"
    """
    names = list(known)
    folded = {name.casefold(): name for name in reversed(names)}
    near = difflib.get_close_matches(word.casefold(), folded, 1, 0.5)
    return f"did you mean {folded[near[0]]!r}?" if near else f"there are: {', '.join(names) or 'none'}"
