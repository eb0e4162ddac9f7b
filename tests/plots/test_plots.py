from __future__ import annotations

import subprocess
import sys
from itertools import combinations
from pathlib import Path

import pytest

import colonysim
from colonysim.errors import ColonysimError, MissingExtraError
from colonysim.plots import draw
from colonysim.trace.schema import Event

MAPS = ("sanity", "easy", "medium", "hard")


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, colonysim.Run]:
    folder = tmp_path_factory.mktemp("runs")
    return {name: colonysim.run(name, seed=1, episodes=2, out=folder / name) for name in MAPS}


def test_everything_can_be_drawn_from_the_directory_alone(runs: dict[str, colonysim.Run], tmp_path: Path) -> None:
    assert runs["sanity"].path is not None
    run = colonysim.Run.open(runs["sanity"].path)
    images = draw(run, out=tmp_path, episodes=[2])
    names = {image.name for image in images}
    assert names == {
        "D.png", "E.png", "H-hole3.png", "H-hole7.png", "B-box0.png", "B-box1.png", "map.png", "trajectories.png",
        "episodes.png",
    }  # fmt: skip
    assert all(image.read_bytes().startswith(b"\x89PNG") for image in images)
    assert {image.name for image in tmp_path.iterdir()} == names


def test_a_choice_of_hole_box_episodes_and_format(runs: dict[str, colonysim.Run], tmp_path: Path) -> None:
    images = draw(runs["hard"], what=["H", "B"], hole=29, box=3, episodes=[2], out=tmp_path, kind="svg")
    assert [image.name for image in images] == ["H-hole29.svg", "B-box3.svg"]
    assert "hole at node 29" in images[0].read_text() or images[0].stat().st_size > 10_000
    again = draw(runs["hard"], what=["map"], out=tmp_path / "a")[0].read_bytes()
    assert draw(runs["hard"], what=["map"], out=tmp_path / "b")[0].read_bytes() == again


@pytest.mark.parametrize("name", MAPS)
def test_no_two_labels_of_a_map_overlap(runs: dict[str, colonysim.Run], name: str) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    from colonysim.plots.maps import map_figure

    figure = map_figure(runs[name], 2)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    for axes in figure.axes:
        assert axes.get_xlabel() and axes.get_ylabel() and axes.get_title()
        texts = [text for text in axes.texts if text.get_text()]
        assert len(texts) >= len(runs[name].scenario.topology)
        boxes = [(text.get_text(), text.get_window_extent(canvas.get_renderer())) for text in texts]
        for (one, a), (other, b) in combinations(boxes, 2):
            assert not a.overlaps(b), (one, other)


def test_mistakes_are_told_before_anything_is_drawn(runs: dict[str, colonysim.Run], tmp_path: Path) -> None:
    run = runs["sanity"]
    out = tmp_path / "plots"
    for words, said in [
        ({"what": ["D", "mpa"]}, "did you mean 'map'"),
        ({"episodes": [7]}, "it has 1 to 2"),
        ({"hole": 4}, "no hole at node 4; there are: 3, 7"),
        ({"box": 2}, "the boxes are 0 to 1"),
    ]:
        with pytest.raises(ColonysimError, match=said):
            draw(run, out=out, **words)  # type: ignore[arg-type]
    assert not out.exists()
    with pytest.raises(ColonysimError, match="kept no trace"):
        draw(colonysim.run("sanity", episodes=1, trace=False))


def test_without_matplotlib_the_command_to_install_it_is_named(
    runs: dict[str, colonysim.Run], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'colonysim\[plot\]'"):
        draw(runs["sanity"])


def test_the_package_of_plots_imports_no_matplotlib() -> None:
    program = "import sys, colonysim.plots; assert not {'matplotlib', 'numpy', 'pyarrow'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", program], check=True)


def test_events_tell_where_everything_went() -> None:
    from colonysim.plots.replay import blocked_edges, follow

    scenario = colonysim.load_scenario("sanity")
    events = [
        Event(1, 1.0, "end", 0, "take", 0, 1, 0, 3, "arrived", now_at=1),
        Event(1, 2.0, "end", 0, "push", 1, 3, 0, 3, "arrived", now_at=1),
        Event(1, 3.0, "end", 0, "travel", 1, 3, status="arrived", now_at=3),
        Event(1, 4.0, "end", 0, "push", 3, 4, 1, 7, "failed", now_at=3),
    ]
    ways = follow(scenario, events)
    assert ways.agents[0] == [0, 1, 3]
    assert ways.boxes == {0: [1, 3], 1: [2]}
    before = blocked_edges(scenario, {0: 1, 1: 2})
    after = blocked_edges(scenario, {0: 3, 1: 2})
    assert (1, 3) in before and (1, 3) not in after
    assert (3, 4) in before and (3, 4) not in after and (4, 7) in after


def test_running_intervals_are_students() -> None:
    from colonysim.plots.results import running_interval

    assert running_interval([3.0]) == [(3.0, 3.0, 3.0)]
    mean, low, high = running_interval([1.0, 2.0, 3.0, 4.0, 5.0])[2]
    assert mean == 3.0 and low == pytest.approx(3 - 1.9632, abs=1e-3) and high == pytest.approx(3 + 1.9632, abs=1e-3)
    assert len(running_interval(list(range(30)))) == 30
