"""Every notebook in docs/notebooks runs from its first cell to its last, and its stored outputs are of today."""

from __future__ import annotations

from pathlib import Path

import pytest

nbformat = pytest.importorskip("nbformat")
pytest.importorskip("nbclient")
pytest.importorskip("ipykernel")

from executing import NOTEBOOKS, executed, printed, to_store  # noqa: E402


@pytest.mark.parametrize("name", ["first_colony", "own_rule", "sweep_and_statistics"])
def test_a_notebook_runs_and_prints_what_is_stored(name: str, tmp_path: Path) -> None:
    path = NOTEBOOKS / f"{name}.ipynb"
    assert printed(executed(path, tmp_path)) == printed(nbformat.read(path, as_version=4)), (
        "renew the outputs: python tests/notebooks/executing.py"
    )


@pytest.mark.usefixtures("some_engine")
def test_the_notebook_on_rigid_bodies_runs(tmp_path: Path) -> None:
    executed(NOTEBOOKS / "learned_push.ipynb", tmp_path)


def test_all_of_them_are_tested_and_none_holds_a_page_or_an_error() -> None:
    names = {path.stem for path in NOTEBOOKS.glob("*.ipynb")}
    assert names == {"first_colony", "own_rule", "sweep_and_statistics", "learned_push"}
    for name in names:
        book = nbformat.read(NOTEBOOKS / f"{name}.ipynb", as_version=4)
        outputs = [output for cell in book.cells for output in cell.get("outputs", ())]
        assert outputs and all(output.output_type != "error" for output in outputs)
        assert to_store(book) == nbformat.read(NOTEBOOKS / f"{name}.ipynb", as_version=4)
