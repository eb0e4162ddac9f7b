"""The gallery has what it lists: scenarios that do what the page says, small pictures, replay pages."""

from __future__ import annotations

import importlib.util
import re
import statistics
import sys
from pathlib import Path

import pytest

import colonysim
from colonysim.trace.schema import Event

GALLERY = Path(__file__).parents[2] / "docs" / "gallery"
PAGE = (GALLERY / "index.md").read_text(encoding="utf-8")

spec = importlib.util.spec_from_file_location("gallery_make", GALLERY / "make.py")
assert spec is not None and spec.loader is not None
make = importlib.util.module_from_spec(spec)
sys.modules["gallery_make"] = make
spec.loader.exec_module(make)


def ends(name: str, overrides: dict[str, object] | None = None, **given: object) -> list[Event]:
    """The ends of the episodes of a colony of the gallery, run as the gallery does."""
    scenario = colonysim.load_scenario(GALLERY / f"{name}.yaml", overrides=overrides)
    return [*colonysim.simulate(scenario, seed=1, kinds=["episode"], **given)]  # type: ignore[arg-type]


def mean_seconds(events: list[Event]) -> float:
    return statistics.mean(event.time for event in events)


def test_the_page_shows_every_colony_with_its_picture_replay_and_scenario() -> None:
    shown = re.findall(r"\]\((\S+)\.png\)\]\((\S+)\.html\)", PAGE)
    assert shown == [(exhibit.name, exhibit.name) for exhibit in make.EXHIBITS] and len(shown) == 12
    files = {path.stem for path in GALLERY.glob("*.yaml")}
    assert set(re.findall(r"\[Scenario\]\((\S+)\.yaml\)", PAGE)) == files
    assert files == {exhibit.name for exhibit in make.EXHIBITS if not exhibit.scenario}
    for name, _ in shown:
        assert 2_000 < (GALLERY / f"{name}.png").stat().st_size < 150_000, name


@pytest.mark.parametrize("name", ["ditch", "deep", "door", "bridges", "fleeing", "scouts", "rounds", "chance"])
def test_all_robots_arrive(name: str) -> None:
    assert {event.status for event in ends(name)} == {"goal"}


def test_what_the_page_says_of_them() -> None:
    assert all(event.status == "lost" for event in ends("dying"))
    assert [event.status for event in ends("worn-out")].count("max_steps") == 2
    assert mean_seconds(ends("worn-out")) > 4 * mean_seconds(ends("worn-out", {"faults": None}))
    lasting = ends("fleeing", {"policy.distance_half_life": None})
    assert 1.5 < mean_seconds(lasting) / mean_seconds(ends("fleeing")) < 2.0
    bridges = [event.time for event in ends("bridges")]
    assert max(bridges[4:7]) > 2 * bridges[3] and bridges[9] < max(bridges[4:7])
    assert mean_seconds(ends("chance", policy="random")) > 4 * mean_seconds(ends("chance"))


def test_a_thousand_robots_start() -> None:
    with colonysim.Colony(colonysim.load_scenario(GALLERY / "thousand.yaml"), seed=1) as colony:
        colony.run_until(time=3.0)
        assert len(colony.agents.node) == 1000


def test_one_is_made_with_picture_and_replay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("matplotlib")
    pytest.importorskip("PIL")
    (tmp_path / "ditch.yaml").write_bytes((GALLERY / "ditch.yaml").read_bytes())
    monkeypatch.setattr(make, "HERE", tmp_path)
    monkeypatch.setattr(make, "EXHIBITS", make.EXHIBITS[:1])
    monkeypatch.setattr(sys, "argv", ["make.py", "ditch"])
    assert make.main() == 0
    assert (tmp_path / "ditch.png").read_bytes()[:4] == b"\x89PNG"
    assert 100_000 < (tmp_path / "ditch.html").stat().st_size < 300_000
    (tmp_path / "ditch.html").unlink()
    make.make_missing_replays()
    assert (tmp_path / "ditch.html").is_file()
    (tmp_path / "ditch.html").write_text("kept", "utf-8")
    make.make_missing_replays()
    assert (tmp_path / "ditch.html").read_text("utf-8") == "kept"


def test_without_an_engine_the_replay_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(make, "HERE", tmp_path)
    monkeypatch.setattr(make, "EXHIBITS", make.EXHIBITS[-1:])
    monkeypatch.setattr("colonysim.physics.engine_trouble", lambda engine: "no engine here")
    make.make_missing_replays()
    assert "no engine here" in (tmp_path / "hard.html").read_text("utf-8")
