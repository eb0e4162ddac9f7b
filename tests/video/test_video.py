"""The written files are decoded again and looked at."""

from __future__ import annotations

import itertools
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import colonysim
from colonysim.cli import app
from colonysim.errors import ColonysimError, TraceError

pytest.importorskip("matplotlib")
av = pytest.importorskip("av")

from colonysim.video import write_video  # noqa: E402
from colonysim.video.motion import by_events, by_poses, coming_and_leaving  # noqa: E402

_SMALL = (240, 180)


def _decoded(path: Path) -> tuple[list[Any], float, str]:
    """Images, seconds and codec of a file."""
    with av.open(str(path)) as container:
        codec = container.streams.video[0].codec_context.name
        frames = list(container.decode(video=0))
    last = frames[-1]
    seconds = float((last.pts + last.duration) * Fraction(last.time_base))
    return [frame.to_ndarray(format="rgb24").astype(int) for frame in frames], seconds, codec


def _looks_alive(images: list[Any]) -> None:
    assert all(image.std() > 10 for image in images)  # not blank
    scene = [image[:, : image.shape[1] * 3 // 4] for image in images]
    moved = [np.abs(b - a).max() > 60 for a, b in itertools.pairwise(scene)]
    assert sum(moved) > len(moved) / 2
    assert (np.abs(scene[-1] - scene[0]).max(axis=2) > 60).mean() > 0.002


def test_an_mp4_plays_for_as_long_as_asked_and_moves(easy: colonysim.Run, tmp_path: Path) -> None:
    told: list[tuple[int, int]] = []
    path = write_video(easy, tmp_path / "a.mp4", seconds=2, size=_SMALL, progress=lambda *done: told.append(done))
    images, seconds, codec = _decoded(path)
    assert (codec, len(images), images[0].shape) == ("h264", 30, (180, 240, 3))
    assert seconds == pytest.approx(2.0)
    assert told == [(i, 30) for i in range(1, 31)]
    _looks_alive(images)


def test_a_gif_repeats_and_moves(easy: colonysim.Run, tmp_path: Path) -> None:
    from PIL import Image

    path = write_video(easy, tmp_path / "a.gif", seconds=2, fps=15, size=_SMALL)
    with Image.open(path) as gif:
        assert gif.info["loop"] == 0
        images, spent = [], 0
        for i in range(gif.n_frames):
            gif.seek(i)
            spent += gif.info["duration"]
            images.append(np.asarray(gif.convert("RGB")).astype(int))
    assert spent == 2000  # though a fifteenth of a second is no whole number of hundredths
    assert images[0].shape == (180, 240, 3)
    _looks_alive(images)


def test_another_episode_is_another_film(easy: colonysim.Run, tmp_path: Path) -> None:
    one, last, two = (
        write_video(easy, tmp_path / f"{name}.gif", episode=episode, seconds=1, size=_SMALL).read_bytes()
        for name, episode in (("one", 1), ("last", None), ("two", 2))
    )
    assert last == two
    assert one != two


def test_agents_move_along_their_edges_and_end_where_the_events_say(easy: colonysim.Run) -> None:
    episode = easy.episodes[-1]
    times = np.linspace(0, episode.sim_seconds, 400)
    motion = by_events(easy, episode.episode, times)
    topology = easy.scenario.topology
    nodes = np.column_stack([topology.x, topology.y])
    assert np.allclose(motion.agents[0, :, :2], nodes[list(easy.scenario.agents)])
    assert np.allclose(motion.agents[-1, :, :2], nodes[easy.scenario.goal])
    assert np.isfinite(coming_and_leaving(easy, episode.episode)[1]).all()
    pushed = np.abs(motion.boxes[-1] - motion.boxes[0]).max(axis=1) > 0
    assert pushed.any()
    assert np.allclose(motion.boxes[-1, :, :2], nodes[motion.boxes_at[-1]])
    longest = max(max(lengths) for lengths in topology.lengths if lengths)
    steps = np.hypot(*np.moveaxis(np.diff(motion.agents[..., :2], axis=0), -1, 0))
    assert steps.max() < longest / 2  # nobody jumps


def test_filled_holes_are_counted(easy: colonysim.Run) -> None:
    from colonysim.video.film import Film

    film = Film(easy, easy.episodes[-1], frames=20, fps=10, size=_SMALL)
    assert film._scene.filled(0) == 0
    assert film._scene.filled(19) == len(easy.scenario.holes) > 0


def test_rigid_bodies_are_drawn_where_they_were(engine: str, tmp_path: Path) -> None:
    run = colonysim.run(
        "sanity", backend=engine, seed=10, episodes=1, out=tmp_path / "run", backend_options={"push": "scripted"}
    )
    poses = run.table("poses").to_pylist()
    row = next(row for row in poses if row["body"] == "agent" and row["number"] == 0 and row["time"] > 2)
    motion = by_poses(run, 1, np.array([row["time"]]))
    assert motion.agents[0, 0] == pytest.approx([row["x"], row["y"], row["yaw"]])
    _looks_alive(_decoded(write_video(run, tmp_path / "a.mp4", seconds=1, size=(320, 240)))[0])


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("a.avi", {}, r"a video ends in \.mp4 or \.gif"),
        ("a.mp4", {"episode": 7}, "no episode 7 in this run; it has 1 to 2"),
        ("a.mp4", {"size": (241, 180)}, "must be even"),
        ("a.gif", {"size": (1, 1)}, "pixels each way"),
        ("a.gif", {"seconds": 1e6}, "frames"),
    ],
)
def test_what_cannot_be_made_is_said(
    easy: colonysim.Run, tmp_path: Path, name: str, options: dict[str, Any], message: str
) -> None:
    with pytest.raises(ColonysimError, match=message):
        write_video(easy, tmp_path / name, **options)
    assert not list(tmp_path.iterdir())


def test_a_run_that_kept_no_trace_cannot_be_filmed(tmp_path: Path) -> None:
    run = colonysim.run("sanity", seed=10, episodes=1, trace=False)
    with pytest.raises(TraceError, match="kept no trace"):
        write_video(run, tmp_path / "a.gif")


@pytest.mark.parametrize("ending", ["mp4", "gif"])
def test_an_interrupted_film_leaves_nothing_behind(easy: colonysim.Run, tmp_path: Path, ending: str) -> None:
    def interrupt(done: int, total: int) -> None:
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_video(easy, tmp_path / f"a.{ending}", seconds=1, size=_SMALL, progress=interrupt)
    assert not list(tmp_path.iterdir())


def test_the_command_replaces_a_file_only_when_told(easy: colonysim.Run, tmp_path: Path) -> None:
    out = tmp_path / "a.gif"
    out.write_text("mine")
    arguments = ["video", str(easy.path), str(out), "--seconds", "0.5", "--size", "240x180"]
    refused = CliRunner().invoke(app, arguments)
    assert refused.exit_code == 2
    assert "exists already; it is not overwritten" in refused.output
    assert out.read_text() == "mine"
    made = CliRunner().invoke(app, [*arguments, "--overwrite"])
    assert (made.exit_code, made.stdout.strip()) == (0, str(out))
    assert out.read_bytes()[:6] == b"GIF89a"


def test_a_size_that_is_none_is_refused(easy: colonysim.Run, tmp_path: Path) -> None:
    refused = CliRunner().invoke(app, ["video", str(easy.path), str(tmp_path / "a.gif"), "--size", "big"])
    assert refused.exit_code == 2
    assert "is no size" in refused.output


@pytest.mark.parametrize("seconds", [float("nan"), float("inf"), -float("inf"), 1e300, 0.0, -1.0])
def test_a_length_that_is_none_is_refused(seconds: float, easy: colonysim.Run, tmp_path: Path) -> None:
    with pytest.raises(ColonysimError, match=r"frames|seconds"):
        write_video(easy, tmp_path / "film.gif", seconds=seconds)
    done = CliRunner().invoke(app, ["video", str(easy.path), str(tmp_path / "film.gif"), f"--seconds={seconds}"])
    assert done.exit_code == 2 and "Traceback" not in done.output
    assert list(tmp_path.iterdir()) == []


def test_a_film_shows_what_the_timeline_changes(tmp_path: Path) -> None:
    from colonysim.video.film import Film

    changes = [
        {"time": 2, "remove_edge": [1, 2]}, {"time": 3, "set_surface": {"node": 9, "z": 1}},
        {"time": 4, "move_goal": 10},
        {"time": 5, "fail": {"agents": [0], "seconds": 4}}, {"time": 6, "wipe": {}}, {"time": 11, "add_edge": [1, 2]},
    ]  # fmt: skip
    place = {"topology": {"kind": "grid", "columns": 6, "rows": 2}, "agents": [0], "goal": 5, "changes": changes}
    held = {**place, "agents": [0, 6], "policy": "random", "time_limit": 14.0}
    run = colonysim.run(colonysim.scenario_from_document(held), seed=1, episodes=1, out=tmp_path / "run")
    film = Film(run, run.episodes[0], frames=150, fps=10, size=_SMALL)

    def at(time: float) -> Any:
        film[int(np.searchsorted(film._times, time))]
        return film._scene

    early = at(1.5)
    assert (early._stage.goal, (1, 2) in early._stage.edges, early._stage.steps) == (5, True, [])
    late = at(8.0)
    assert (late._stage.goal, (1, 2) in late._stage.edges) == (10, False)
    assert late._stage.steps == [(3, 9), (8, 9), (9, 10)]
    assert tuple(late._goal._discs[0].center) == (4.0, 1.0)
    colours = {tuple(colour) for colour in late._agents.get_facecolor()}
    assert len(colours) == 2, "who failed has another colour"
    assert film._caption._last.get_text().replace("\n", " ") == "marks are wiped away"
    assert (1, 2) in at(13.0)._stage.edges
