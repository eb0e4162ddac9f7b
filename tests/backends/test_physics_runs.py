"""Whole episodes with rigid bodies: the same every time, the same checks as any backend, and they can be stopped."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from backends.places import FORK, LANE, place, two_levels

import colonysim
from colonysim.backends.physics import Physics
from colonysim.backends.protocol import TraceRow
from colonysim.simulation import simulate
from colonysim.testing import check_backend
from colonysim.trace.reader import Run
from colonysim.trace.schema import Event, Sink, Table

pytestmark = pytest.mark.usefixtures("engine")

SHORT = {"max_steps": 9}
HASH = """
import sys, colonysim
run = colonysim.run("hard", backend=sys.argv[3], seed=int(sys.argv[1]), episodes=1, trace=False,
                    overrides={"max_steps": 9}, backend_options={"push": sys.argv[2]})
print(run.trace_sha256)
"""


def short_run(push: str, seed: int = 3) -> tuple[Run, list[Event]]:
    events: list[Event] = []
    run = colonysim.run(
        "hard", backend="physics", seed=seed, episodes=1, trace=False, overrides=SHORT,
        backend_options={"push": push}, on_event=lambda event, _: events.append(event),
    )  # fmt: skip
    return run, events


@pytest.mark.parametrize("push", ["scripted", "staged"])
def test_the_same_seed_gives_the_same_trace(engine: str, push: str) -> None:
    one, events = short_run(push)
    other, _ = short_run(push)
    assert any(event.action == "push" and event.status == "arrived" for event in events)
    assert one.trace_sha256 == other.trace_sha256
    told = subprocess.run(
        [sys.executable, "-c", HASH, "3", push, engine], capture_output=True, text=True, check=True, timeout=120
    )
    assert told.stdout.split()[-1] == one.trace_sha256


def test_another_seed_gives_another_trace() -> None:
    assert short_run("scripted", 3)[0].trace_sha256 != short_run("scripted", 4)[0].trace_sha256


def test_what_nobody_keeps_is_not_recorded_and_nothing_else_changes() -> None:
    handed_over: list[TraceRow] = []
    kept: list[str] = []

    class Watched(Physics):
        def rows(self) -> list[TraceRow]:
            rows = list(super().rows())
            handed_over.extend(rows)
            return rows

    class Keeper:
        def write(self, table: Table, row: tuple[object, ...]) -> None:
            kept.append(table)

    def events(sink: Sink | None) -> list[Event]:
        backend = Watched(push="scripted")
        return list(simulate(place(LANE), backend=backend, episodes=1, seed=5, sink=sink))

    recorded = events(Keeper())
    assert {"poses", "controls"} <= {row.table for row in handed_over} & set(kept)
    handed_over.clear()
    bare = events(None)
    assert not handed_over
    assert bare == recorded


def test_an_episode_depends_on_nothing_before_it() -> None:
    scenario = place(LANE)
    backend = Physics(push="scripted")
    ends = []
    for _ in range(2):
        events = list(simulate(scenario, backend=backend, episodes=1, seed=5))
        ends.append([(e.time, e.kind, e.node, e.status) for e in events])
    assert ends[0] == ends[1]
    assert ends[0][-1][3] == "goal"


@pytest.mark.parametrize(("push", "where", "steps"), [("staged", LANE, 6), ("scripted", FORK, 4)])
def test_the_backend_keeps_its_promises(push: str, where: dict[str, Any], steps: int) -> None:
    check_backend(lambda: Physics(push=push), scenarios=[place(where, max_steps=steps)], episodes=2)


def test_a_run_that_is_interrupted_is_readable_and_frees_the_engine(tmp_path: Path) -> None:
    backend = Physics(push="scripted")
    told = 0

    def stop(event: Event, run: Run) -> None:
        nonlocal told
        told += 1
        if told == 6:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        colonysim.run(place(LANE), backend=backend, seed=1, out=tmp_path / "run", on_event=stop)
    assert backend._scene is None
    run = Run.open(tmp_path / "run")
    assert run.manifest["status"] == "interrupted"
    assert len(list(run.events())) >= 5


@pytest.mark.parametrize("turned", [math.pi / 2, 2.2])
def test_a_box_goes_up_a_ramp_in_any_direction_and_fills_a_hole(turned: float) -> None:
    climb = two_levels(turned, 3, 5)
    scenario = place(
        dict(climb.document), holes=[{"node": 6, "depth": 0.35}], detection_radius=30, max_steps=40, goal=7
    )
    events = list(simulate(scenario, backend=Physics(push="scripted"), episodes=1, seed=1))
    assert events[-1].status == "goal"
    assert not [event for event in events if event.kind == "end" and event.status != "arrived"]


def test_a_window_without_a_display_is_one_message_and_leaves_no_run(engine: str, tmp_path: Path) -> None:
    if engine != "bullet":
        pytest.skip("only Bullet has a window")
    # The engine ends the process, so it has to be one of its own.
    environment = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
    command = [sys.executable, "-m", "colonysim", "run", "sanity", "--backend", "bullet", "--gui", "-n", "1"]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "") and not list(tmp_path.iterdir())
    [said] = [line for line in done.stderr.splitlines() if not line.startswith("pybullet build time")]
    assert said.startswith("Error: gui: ") and "display" in said
