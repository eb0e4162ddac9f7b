"""Files appear whole or not at all."""

from pathlib import Path

import pytest

from colonysim.errors import ColonysimError, TraceError
from colonysim.files import replace_file, replacing


def test_a_file_that_fails_half_way_leaves_the_old_one_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    replace_file(path, "old")
    with pytest.raises(ZeroDivisionError), replacing(path) as temporary:
        temporary.write_text("half")
        raise ZeroDivisionError
    said = r"table\.csv: cannot be written: no room"
    with pytest.raises(TraceError, match=said), replacing(path, TraceError) as temporary:
        temporary.write_text("half")
        raise OSError(28, "no room")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_missing_folders_are_made(tmp_path: Path) -> None:
    replace_file(tmp_path / "a" / "b", b"\x00")
    assert (tmp_path / "a" / "b").read_bytes() == b"\x00"


@pytest.mark.parametrize("name", ["x" * 300, "file/below"])
def test_what_cannot_be_written_is_one_error(tmp_path: Path, name: str) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(ColonysimError, match="cannot be written"):
        replace_file(tmp_path / name, "text")
