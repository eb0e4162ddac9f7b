"""Files are written under a temporary name and renamed, so that nobody sees one half written."""

from __future__ import annotations

import os
from contextlib import contextmanager
from typing import TYPE_CHECKING

from colonysim.errors import ColonysimError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

__all__ = ["replace_file", "replacing"]


@contextmanager
def replacing(path: Path, error: type[ColonysimError] = ColonysimError) -> Iterator[Path]:
    """A temporary path beside `path`, which takes its place when the block ends well and is removed otherwise.

    Missing parent folders are made.

    Args:
        path: The file to write.
        error: What to raise if it cannot be written.

    Raises:
        ColonysimError: The file cannot be written; what stood there before is untouched.

    Example:
        ```python
        with replacing(Path("table.csv")) as temporary:
            temporary.write_text("a,b")
        ```
    """
    # Two processes that write the same file do not disturb each other: one of them wins, as a whole.
    temporary = path.with_name(f".{os.getpid()}-{path.name[-64:]}.tmp")
    try:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            yield temporary
            temporary.replace(path)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise
    except OSError as reason:
        raise error(f"{path}: cannot be written: {reason.strerror or reason}") from reason


def replace_file(path: Path, content: bytes | str, error: type[ColonysimError] = ColonysimError) -> None:
    """Writes a whole file in one step; text becomes UTF-8.

    Raises:
        ColonysimError: It cannot be written.
    """
    with replacing(path, error) as temporary:
        temporary.write_bytes(content.encode() if isinstance(content, str) else content)
