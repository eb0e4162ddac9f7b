"""Executes a notebook in a folder of its own; as a program, renews the outputs that are stored in docs/notebooks."""

from __future__ import annotations

import re
import sys
import tempfile
from pathlib import Path
from typing import Any

import nbformat
from nbclient import NotebookClient

NOTEBOOKS = Path(__file__).parents[2] / "docs" / "notebooks"
SECONDS = 300
"""A cell that takes longer is an error."""


def executed(path: Path, folder: Path) -> Any:
    """The notebook with its outputs.

    Raises:
        CellExecutionError: A cell has raised an error.
    """
    book = nbformat.read(path, as_version=4)
    place = {"metadata": {"path": str(folder)}}
    NotebookClient(book, timeout=SECONDS, kernel_name="python3", resources=place).execute()
    return book


def to_store(book: Any) -> Any:
    """The same as it is committed: without times, and without replay pages, which nobody could review."""
    for cell in book.cells:
        cell.metadata.pop("execution", None)
        for output in cell.get("outputs", ()):
            if "text" in output:
                output.text = re.sub(r"^pybullet build time: .*\n", "", output.text, flags=re.MULTILINE)
            data = output.get("data", {})
            if "<iframe" in data.get("text/html", ""):
                del data["text/html"]
    book.metadata = {"kernelspec": book.metadata.kernelspec, "language_info": {"name": "python"}}
    return book


def printed(book: Any) -> list[str]:
    """What each code cell has printed, without what went to standard error."""
    return [
        "".join(each.text for each in cell.outputs if each.output_type == "stream" and each.name == "stdout")
        for cell in book.cells
        if cell.cell_type == "code"
    ]


def main() -> None:
    for path in [Path(name) for name in sys.argv[1:]] or sorted(NOTEBOOKS.glob("*.ipynb")):
        with tempfile.TemporaryDirectory() as folder:
            text = nbformat.writes(to_store(executed(path, Path(folder))))
        path.write_text(re.sub(r"\n*\Z", "\n", text), encoding="utf-8")


if __name__ == "__main__":
    main()
