"""Scenario documents on their way out: to a new file, or to standard output."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

__all__ = ["OutOption", "write_document"]

OutOption = Annotated[
    Path | None, typer.Option("--out", "-o", metavar="FILE", help="Where to write. [default: standard output]")
]


def write_document(document: dict[str, Any], out: Path | None) -> None:
    """Writes a scenario file that is not there yet, or prints it.

    Raises:
        ColonysimError: The file is there, or cannot be written.
    """
    from colonysim.cli.console import print_text
    from colonysim.errors import ColonysimError
    from colonysim.files import replace_file
    from colonysim.scenario.invent import to_yaml

    text = to_yaml(document)
    if out is None:
        print_text(text)
        return
    if out.exists() or out.is_symlink():
        raise ColonysimError(f"{out}: exists already; it is not overwritten")
    replace_file(out, text)
