"""Files appear whole or not at all."""

import os
import tempfile
import threading
from pathlib import Path

import pytest

from colonysim.errors import ColonysimError, TraceError
from colonysim.files import alone, create_file, replace_file, replacing


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


@pytest.mark.parametrize("name", ["x" * 300, "file/below", "a\0b", "a\ud800b", "loop/below"])
def test_what_cannot_be_written_is_one_error(tmp_path: Path, name: str) -> None:
    (tmp_path / "file").write_text("in the way")
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(ColonysimError, match="cannot be written"):
        replace_file(tmp_path / name, "text")


def test_no_name_of_a_file_is_one_error_of_every_writer(tmp_path: Path) -> None:
    with pytest.raises(TraceError, match="cannot be written"):
        create_file(tmp_path / "a\0b", "text", TraceError)
    with pytest.raises(TraceError, match="cannot be written"), alone(tmp_path / "a\ud800b", "writes", TraceError):
        pass


@pytest.mark.parametrize("there", [True, False])
def test_behind_a_link_the_file_is_replaced_and_the_link_stays(tmp_path: Path, there: bool) -> None:
    (tmp_path / "far").mkdir()
    target, link = tmp_path / "far" / "target", tmp_path / "link"
    if there:
        target.write_text("old")
    link.symlink_to(Path("far") / "target")
    replace_file(link, "new")
    assert link.is_symlink() and not target.is_symlink() and target.read_text() == "new"
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["far", "link", "target"]


def test_a_directory_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ColonysimError, match="is a directory, expected a file"):
        replace_file(tmp_path, "text")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names here")
@pytest.mark.parametrize("through", ["name", "link", "number"])
def test_a_pipe_is_written_into_and_stays(tmp_path: Path, through: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    pipe, got = tmp_path / "pipe", []
    os.mkfifo(pipe)
    reading = threading.Thread(target=lambda: got.append(pipe.read_bytes()))
    reading.start()
    (tmp_path / "link").symlink_to(pipe)
    number = os.open(pipe, os.O_WRONLY)
    try:
        replace_file(
            {"name": pipe, "link": tmp_path / "link", "number": Path(f"/dev/fd/{number}")}[through], "some text"
        )
    finally:
        os.close(number)
        reading.join(10)
    assert got == [b"some text"] and pipe.is_fifo()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["link", "pipe"]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names here")
def test_a_pipe_whose_reader_goes_is_one_error(tmp_path: Path) -> None:
    near, far = os.pipe()
    os.close(near)
    try:
        with pytest.raises(TraceError, match="cannot be written: Broken pipe"):
            replace_file(Path(f"/dev/fd/{far}"), "text", TraceError)
    finally:
        os.close(far)


def test_a_device_without_room_is_one_error_and_stays(tmp_path: Path) -> None:
    device = tmp_path / "full"
    try:
        os.mknod(device, 0o020666, os.makedev(1, 7))
        device.open("rb").close()
    except (AttributeError, OSError):
        pytest.skip("no device can be made here")
    with pytest.raises(ColonysimError, match="cannot be written: No space left"):
        replace_file(device, "text")
    assert device.is_char_device()
