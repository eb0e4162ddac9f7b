"""Where a training cannot write is found before it has worked for hours, and nothing is left behind."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from test_learning import TINY

from colonysim.errors import ColonysimError
from colonysim.files import check_writable
from colonysim.push.training import calibration, forest, trainer


def _too_late(*_: Any, **__: Any) -> None:
    pytest.fail("the work had begun")


@pytest.mark.parametrize("made", ["push.npz", "push.json", ""])
@pytest.mark.parametrize("kind", ["feasibility", "way", "push"])
def test_an_unwritable_target_is_found_before_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, made: str
) -> None:
    pytest.importorskip("sklearn")
    pytest.importorskip("torch")
    monkeypatch.setattr(forest, "gather_states", _too_late)
    monkeypatch.setattr(calibration, "gather_ways", _too_late)
    monkeypatch.setattr(trainer, "_Run", _too_late)
    out = tmp_path / "out"
    if made:
        (out / made).mkdir(parents=True)
    else:
        out.write_text("a file")
    train = {
        "feasibility": lambda: forest.train_feasibility(out, 0, name="push"),
        "way": lambda: calibration.train_way_chance(out, 0, name="push"),
        "push": lambda: trainer.train_push(TINY, out, 0),
    }
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(ColonysimError, match=made or "out"):
        train[kind]()
    assert [path for path in sorted(tmp_path.rglob("*")) if path.name != ".lock"] == before


def test_what_can_be_written_is_left_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "old").write_text("old")
    for name in ("old", "new", "deep/new"):
        check_writable(tmp_path / name)
    check_writable(Path("/dev/null"))
    assert (tmp_path / "old").read_text() == "old"
    assert {path.name for path in tmp_path.rglob("*")} == {"old", "deep"}
