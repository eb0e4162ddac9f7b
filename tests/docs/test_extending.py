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
    assert len(blocks) == 9
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


def test_the_policy_that_rests_takes_its_parameter_from_the_scenario() -> None:
    names = examples()
    calm = names["CalmDownhill"]
    ends = {}
    for rest in (0, 20):
        place = {"nodes": [[0, 0, 0], [1, 1, 0], [2, 2, 0]], "edges": [[0, 1], [1, 2]], "agents": [0], "goal": 2}
        scenario = colonysim.scenario_from_document({**place, "policy": {"rest": rest}})
        *_, last = simulate(scenario, policy=calm, episodes=1)
        ends[rest] = last.time
    assert 1.0 < ends[0] < 3.0 and ends[20] - ends[0] == pytest.approx(40.0, abs=1.0)
    with pytest.raises(colonysim.ScenarioError, match=r"policy.rset=1: no such parameter; did you mean 'rest'\?"):
        calm(load_scenario("sanity", overrides=["policy.rset=1"]))
    with pytest.raises(colonysim.ScenarioError, match=r"policy.rest=601: .*less than or equal to 600, not 601"):
        calm(load_scenario("sanity", overrides=["policy.rest=601"]))
