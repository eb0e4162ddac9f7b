"""The examples in docs/extending.md run as they stand, one after the other."""

import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import pytest

import colonysim
from colonysim.pheromones import Field, Visit
from colonysim.policies.presets import Colony
from colonysim.scenario.loading import load_scenario
from colonysim.simulation import simulate
from colonysim.trace.reader import Run
from colonysim.world.state import World

pytestmark = pytest.mark.usefixtures("some_engine")

PAGE = Path(__file__).parents[2] / "docs" / "extending.md"


@cache
def examples() -> dict[str, Any]:
    """What the blocks of the page define."""
    names: dict[str, Any] = {"__name__": "examples"}
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert len(blocks) == 8
    for block in blocks:
        exec(compile(block, str(PAGE), "exec"), names)
    return names


def test_the_alarm_fades_and_spreads() -> None:
    world = World(load_scenario("easy"))
    alarm, node = examples()["Alarm"](world), 0
    assert [write.value for write in alarm.deposit(Visit("wait", 0, node))] == [1.0]
    assert alarm.deposit(Visit("arrive", 0, node)) == ()
    world.now = 0.5
    assert alarm.at(node) == pytest.approx(0.5 ** (0.5 / 20.0))
    assert all(alarm.at(other) == 0.0 for other in world.topology.neighbours[node])
    for now, halves in ((1.0, 0.05), (20.0, 1.0), (60.0, 3.0)):
        world.now = now
        assert all(0.0 < alarm.at(other) < alarm.at(node) for other in world.topology.neighbours[node])
        assert sum(write.value for write in alarm.frame()) == pytest.approx(0.5**halves)
    alarm.end_episode()
    world.now = 0.0
    assert sum(write.value for write in alarm.frame()) == pytest.approx(1 / 8)
    alarm.wipe([node])
    assert alarm.at(node) == 0.0 and sum(write.value for write in alarm.frame()) < 1 / 8


def test_the_alarm_is_carried_along(tmp_path: Path) -> None:
    alarm = examples()["Alarm"]

    class Wary(Colony):
        def fields(self, world: World) -> Mapping[str, Field]:
            return {**super().fields(world), "A": alarm(world)}

    colonysim.run(load_scenario("hard"), policy=Wary, episodes=3, seed=1, out=tmp_path / "run")
    values = Run.open(tmp_path / "run").field("A", episode=3)
    assert 0.0 < min(values.values()) < 0.1 < max(values.values())


def test_the_examples_run_and_pass_their_checks() -> None:
    names, scenario = examples(), load_scenario("easy")
    policy, backend = names["Downhill"], names["Slippery"]
    events = list(simulate(scenario, policy=policy, backend=backend(), episodes=1, seed=1))
    assert any(event.reason == "slipped" for event in events)
    assert names["COURIER"].trouble() is None
