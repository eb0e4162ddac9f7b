"""Two runs, sweeps, searches or reproductions started at once into one directory: one has it, the other is refused."""

from __future__ import annotations

from pathlib import Path

import pytest
from contenders import contest

import colonysim
from colonysim.errors import ColonysimError, TraceError
from colonysim.files import alone, create_file
from colonysim.sweep import Store

SAID = {
    "run": "exists already and is not empty",
    "sweep": "another process is running this sweep",
    "search": "another process is running this sweep",
    "reproduction": "another process is reproducing the paper there",
}
MANY = {"run": 200, "sweep": 200, "search": 200, "reproduction": 20}
TRIES = [*((kind, 2) for kind in SAID), *(pytest.param(*many, marks=pytest.mark.slow) for many in MANY.items())]


@pytest.mark.parametrize(("kind", "tries"), TRIES)
def test_exactly_one_of_two_has_the_directory_and_nothing_is_lost(tmp_path: Path, kind: str, tries: int) -> None:
    if kind == "search":
        pytest.importorskip("optuna")
    if kind == "reproduction":
        pytest.importorskip("matplotlib")
    for number, answers in enumerate(contest(kind, tmp_path, tries)):
        assert sorted(won for won, _ in answers) == [False, True], answers
        [(_, refusal)] = [answer for answer in answers if not answer[0]]
        [(_, kept)] = [answer for answer in answers if answer[0]]
        assert SAID[kind] in str(refusal)
        out = tmp_path / f"{kind}-{number}"
        if kind == "run":
            run = colonysim.Run.open(out)
            assert run.status == "finished" and run.trace_sha256 == kept and run.verify()
        elif kind == "reproduction":
            assert (out / "reproduction" / "index.md").exists()
        else:
            assert [entry["status"] for entry in Store(out).entries.values()] == ["succeeded"]
        assert not list(out.rglob("*.tmp"))


def test_a_directory_is_held_until_its_holder_ends(tmp_path: Path) -> None:
    refused = pytest.raises(TraceError, match="another process is at work there")
    with alone(tmp_path / "new", "is at work there"), refused, alone(tmp_path / "new", "is at work there", TraceError):
        pass
    with alone(tmp_path / "new", "is at work there"):
        pass
    (tmp_path / "file").touch()
    with pytest.raises(ColonysimError, match="cannot be written to"), alone(tmp_path / "file", "is at work there"):
        pass


def test_a_file_is_created_once_and_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    create_file(tmp_path / "a", "first\n")
    with pytest.raises(FileExistsError):
        create_file(tmp_path / "a", "second\n")

    def no_links(*_: object) -> None:
        raise PermissionError("no hard links here")

    monkeypatch.setattr(Path, "hardlink_to", no_links)
    create_file(tmp_path / "b", "first\n")
    with pytest.raises(FileExistsError):
        create_file(tmp_path / "b", "second\n")
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a": "first\n", "b": "first\n"}
    with pytest.raises(ColonysimError, match="cannot be written"):
        create_file(tmp_path / "nowhere" / "c", "")
