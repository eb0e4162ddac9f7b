"""Changes by hand, and parameters of policies that change under way."""

from __future__ import annotations

import random
import re
from typing import TYPE_CHECKING, Any

import pytest
from typer.testing import CliRunner

import colonysim
from colonysim import Colony, ColonysimError, Scenario
from colonysim.backends.mock import Mock
from colonysim.cli import app
from colonysim.errors import ScenarioError
from colonysim.policies.uniform import Uniform
from colonysim.testing.sections import add_sections
from colonysim.testing.worlds import random_document
from colonysim.trace.writer import TraceWriter

if TYPE_CHECKING:
    from pathlib import Path

MODES = ("asynchronous", "synchronous")


def writer(episodes: int = 3) -> TraceWriter:
    return TraceWriter(None, {"recorded": {}, "episodes": episodes})


def run_to_end(colony: Colony, sink: TraceWriter) -> str:
    for _ in colony:
        pass
    return sink.finish("finished")


def written(scenario: Scenario, **asked: Any) -> str:
    """The hash of a run in which nothing is done by hand."""
    sink = writer()
    with Colony(scenario, sink=sink, **asked) as colony:
        return run_to_end(colony, sink)


def go_to(colony: Colony, episode: int, time: float) -> None:
    colony.run_until(event=lambda event: (event.episode, event.time) >= (episode, time))


def line(*changes: dict[str, Any], **more: Any) -> Scenario:
    document = {
        "nodes": [[i, 2.0 * i, 0.0] for i in range(6)], "edges": [[i, i + 1] for i in range(5)], "agents": [0, 1],
        "goal": 5, "episodes": 1, "max_steps": 1000, "boxes": [[3, 0.35]], "changes": list(changes), **more,
    }  # fmt: skip
    return colonysim.scenario_from_document(document, source="line")


def anything(rng: random.Random, colony: Colony) -> dict[str, Any]:
    """A change that can be made by hand."""
    scenario = colony.scenario
    ids, group = scenario.topology.ids, rng.choice([None, *(group.name for group in scenario.groups)])
    item: dict[str, Any] = rng.choice([
        {"policy": {"beta": rng.uniform(0, 8), "patience": rng.choice([None, 1.0])}},
        {"policy": {"epsilon": rng.random(), "exploration_evaporation": rng.random(), "box_half_life": 20.0}},
        {"policy": {"hole_half_life": rng.choice([None, 30.0]), "distance_half_life": rng.choice([None, 10.0])}},
        {"policy": {"beta": 0.1, "tries": 1}, **({"group": group} if group else {})},
        {"fail": {"agents": [rng.randrange(len(scenario.agents))], **rng.choice([{}, {"seconds": 7.0}])}},
        {"wipe": rng.choice([{}, {"fields": ["E"]}])},
        {"set_surface": {"node": rng.choice(ids), "z": -1.0}},
        {"remove_edge": rng.choice(scenario.document["edges"])},
        *[{"remove_box": rng.randrange(len(scenario.boxes))} for _ in scenario.boxes[:1]],
        *[{"add_box": {"node": rng.choice([n for n in ids if scenario.topology.index[n] not in scenario.goals]),
                       "height": 0.35}} for _ in range(4)],
    ])  # fmt: skip
    if rng.random() < 0.2:
        item = {"from_episode": colony.episode + 1, "time": round(rng.uniform(0, 9), 1), **item}
    if rng.random() < 0.1:
        item["when"] = {"at_goal": 1}
    return item


@pytest.mark.parametrize("mode", MODES)
def test_what_is_done_by_hand_comes_again_from_the_scenario_with_it(mode: str) -> None:
    """Random worlds with timelines, groups, faults and marks that fade; changed by hand at random moments."""
    made = 0
    for seed in range(20):
        rng = random.Random(seed)
        scenario = colonysim.scenario_from_document(add_sections(rng, random_document(rng)))
        sink = writer()
        with Colony(scenario, mode=mode, seed=seed, episodes=3, sink=sink) as colony:
            for _ in range(rng.randrange(2, 8)):
                for _ in range(rng.randrange(1, 60)):
                    if colony.step() is None:
                        break
                if colony.over:
                    break
                try:
                    change = colony.change(anything(rng, colony))
                except ScenarioError as error:
                    assert "by hand" in str(error)  # nothing has changed
                else:
                    made += 1
                    assert change == colony.scenario.changes[-1]
            found = run_to_end(colony, sink)
            again = colony.scenario
        assert found == written(again, mode=mode, seed=seed, episodes=3), seed
    assert made > 30


@pytest.mark.parametrize("mode", MODES)
def test_a_colony_that_was_changed_by_hand_is_saved_and_forked(mode: str, tmp_path: Path) -> None:
    for seed in range(6):
        colony, rng = Colony("hard", mode=mode, seed=seed, episodes=2), random.Random(seed)
        go_to(colony, 1, rng.uniform(0, 10))
        colony.change({"policy": {"beta": 0.5, "epsilon": 0.4}})
        colony.change({"add_box": {"node": 3, "height": 0.35}})
        for _ in range(rng.randrange(0, 30)):
            colony.step()
        colony.save(tmp_path / "colony.npz")
        twin, loaded = colony.fork(), Colony.load(tmp_path / "colony.npz")
        assert loaded.parameters == colony.parameters
        assert list(colony) == list(twin) == list(loaded)


def test_a_fork_sets_what_a_timeline_has_set_before() -> None:
    with Colony(line({"policy": {"beta": 2.0, "tries": 1}}), seed=1) as colony:
        go_to(colony, 1, 3.0)
        with colony.fork(overrides={"policy.beta": 7.0}) as fork:
            assert fork.parameters[""] == {"beta": 7.0, "tries": 1}


def test_parameters_hold_from_their_moment_on_in_later_episodes_too() -> None:
    scenario = line({"episode": 2, "time": 3.0, "policy": {"beta": 0.25}}, episodes=3)
    held = {}
    with Colony(scenario, seed=1) as colony:
        for event in colony:
            held[event.episode, event.time] = colony.parameters[""].get("beta")
    assert {beta for (episode, time), beta in held.items() if (episode, time) < (2, 3.0)} == {None}
    assert {beta for (episode, time), beta in held.items() if (episode, time) >= (2, 3.0)} == {0.25}


def test_agents_decide_by_the_new_parameters() -> None:
    """With beta 0 all choices are equally likely, to the last digit."""
    chances: list[tuple[float, list[float]]] = []

    class Decisions:
        def write(self, table: str, row: Any) -> None:
            if table == "decisions":
                chances.append((row[1], list(row[-1])))

    scenario = line({"time": 6.0, "policy": {"beta": 0.0, "epsilon": 0.0}}, boxes=[])
    with Colony(scenario, seed=1, sink=Decisions()) as colony:  # type: ignore[arg-type]
        list(colony)
    before = [row for time, row in chances if time < 6.0 and len(row) > 1]
    after = [row for time, row in chances if time >= 6.0 and len(row) > 1]
    assert before
    assert any(max(row) - min(row) > 0.1 for row in before)
    assert after
    assert all(max(row) == pytest.approx(min(row)) for row in after)


def test_the_chance_to_explore_is_set_in_the_agents_memories() -> None:
    with Colony(line(episodes=2), seed=1) as colony:
        go_to(colony, 1, 3.0)
        colony.change({"policy": {"epsilon": 0.9}})
        go_to(colony, 1, 5.0)
        assert [memory.epsilon for memory in colony._memories] == [0.9, 0.9]
        go_to(colony, 2, 1.0)
        assert [memory.epsilon for memory in colony._memories] == pytest.approx([0.72, 0.72])


def test_marks_fade_by_another_half_life_from_the_moment_on_at_which_it_is_set() -> None:
    with Colony(line(boxes=[]), seed=1) as colony:
        go_to(colony, 1, 4.0)
        before = colony.fields["E"].values()
        colony.change({"policy": {"exploration_half_life": 1.0, "distance_half_life": 1.0}})
        second = colony.scenario.changes[-1].time
        colony.run_until(time=second)
        assert colony.fields["E"].values() == pytest.approx(before)
        twin = colony.fork()
        twin.run_until(time=second + 0.01)
        assert twin.fields["E"].values().max() == pytest.approx(before.max() * 0.5**0.01)


def test_a_group_gets_parameters_of_its_own() -> None:
    groups = [{"name": "some", "agents": [0]}, {"name": "others", "agents": [1]}]
    scenario = line({"time": 2.0, "group": "others", "policy": {"beta": 1.0}}, groups=groups, agents=None)
    with Colony(scenario, seed=1) as colony:
        go_to(colony, 1, 4.0)
        assert [colony.parameters[name].get("beta") for name in ("", "some", "others")] == [None, None, 1.0]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"policy": {"bta": 1.0}}, r"line.yaml:9:15: changes.0.policy.bta: no such parameter; did you mean 'beta'"),
        ({"policy": {"beta": -1.0}}, r"changes.0.policy.beta: .*greater than or equal to 0"),
        ({"policy": {}}, r"changes.0.policy: .*at least 1"),
        ({"policy": {"name": "paper"}}, r"changes.0.policy.name: cannot change under way"),
        ({"policy": {"hole_diffusion": 0.5}}, r"changes.0.policy.hole_diffusion: cannot change under way"),
        ({"policy": {"extra_fields": ["x:Y"]}}, r"changes.0.policy.extra_fields: cannot change under way"),
        ({"policy": {"beta": 1.0}, "group": "us"}, r"changes.0.group: no group 'us'; there are: none"),
        ({"wipe": {}, "group": "us"}, r"changes.0.group: stands beside `wipe`, expected it beside `policy`"),
    ],
)
def test_parameters_that_cannot_be_are_refused_where_they_stand(
    change: dict[str, Any], words: str, tmp_path: Path
) -> None:
    file = tmp_path / "line.yaml"
    key = next(iter(change))
    inside = "{" + ", ".join(f"{name}: {value}" for name, value in change[key].items()) + "}"
    rest = "".join(f", {name}: {value}" for name, value in change.items() if name != key)
    file.write_text(
        "nodes: [[0, 0, 0], [1, 2, 0]]\nedges: [[0, 1]]\nagents: [0]\ngoal: 1\n\n\n\nchanges:\n"
        f"  - {{{key}: {inside}{rest}}}\n"
    )
    with pytest.raises(ScenarioError, match=words):
        Colony(file)
    told = CliRunner().invoke(app, ["validate", str(file)])
    assert told.exit_code == 2
    assert re.search(words, told.output)


@pytest.mark.parametrize(
    ("item", "words"),
    [
        ({"policy": {"bta": 1.0}}, r"by hand: changes.0.policy.bta: no such parameter; did you mean 'beta'"),
        ({"add_agent": 0}, "an agent cannot join by hand"),
        ({"add_edge": [0, 5]}, "by hand no edge can come"),
        ({"move_goal": 2}, "by hand the goal can only move"),
        ({"add_box": {"node": 5, "height": 0.3}}, "a box appears on the goal"),
        ({"fail": {"agents": [7]}}, "there is no agent 7"),
        ({"time": 1.0, "episode": 1, "wipe": {}}, r"changes.0.time: 1 s of this episode is past"),
        ({"from_episode": 3, "wipe": {}}, "would come in episode 3, and the last one is 2"),
        ({"wipe": {"fields": ["Q"]}}, "the policy has no field 'Q'"),
        ({"wipes": {}}, "unknown field; did you mean 'wipe'"),
        ({}, "says not what happens"),
        ("wipe", "expected a mapping"),
    ],
)
def test_what_cannot_be_done_by_hand_is_refused_and_changes_nothing(item: Any, words: str) -> None:
    plain = list(Colony(line(episodes=2), seed=4))
    with Colony(line(episodes=2), seed=4) as colony:
        begun = [colony.step() for _ in range(8)]
        with pytest.raises(ColonysimError, match=words):
            colony.change(item)
        assert begun + list(colony) == plain


def test_a_change_between_two_episodes_is_one_of_the_next() -> None:
    with Colony(line(episodes=2), seed=1) as colony:
        colony.run_until(episode=1)
        change = colony.change({"fail": {"agents": [1]}})
        assert (change.first, change.last, change.time) == (2, 2, 0.0)
        assert [event.agent for event in colony if event.kind == "lost"] == [1]
        with pytest.raises(ColonysimError, match="has come to its end"):
            colony.change({"wipe": {}})


def test_a_policy_that_was_given_as_an_object_has_no_parameters_to_set() -> None:
    with Colony(line(), policy=Uniform(line()), seed=1) as colony:
        colony.step()
        with pytest.raises(ScenarioError, match="given as an object"):
            colony.change({"policy": {"beta": 1.0}})
        colony.change({"fail": {"agents": [0]}})
        assert any(event.kind == "lost" for event in colony)


def test_a_backend_with_a_clock_of_its_own_comes_to_the_same() -> None:
    def changed(items: list[tuple[float, dict[str, Any]]]) -> tuple[str, Scenario]:
        sink = writer()
        with Colony(line(episodes=2), backend=Mock(tick=0.1, seconds=1.37), seed=2, sink=sink) as colony:
            for time, item in items:
                go_to(colony, 1, time)
                colony.change(item)
            return run_to_end(colony, sink), colony.scenario

    found, scenario = changed([(3.0, {"policy": {"beta": 0.5}}), (5.0, {"remove_edge": [2, 3]}), (9.0, {"wipe": {}}),
                               (11.0, {"add_edge": [2, 3]})])  # fmt: skip
    assert found == written(scenario, backend=Mock(tick=0.1, seconds=1.37), seed=2)


def test_a_run_that_was_changed_by_hand_is_one_of_the_scenario_with_the_changes(tmp_path: Path) -> None:
    items: list[dict[str, Any]] = [{"policy": {"beta": 0.5}}, {"add_box": {"node": 3, "height": 0.35}}]

    def attend(colony: Colony, share: Any) -> None:
        made = len(colony.scenario.changes)
        if made < 2 and colony.now > 5.0:
            colony.change(items[made])

    run = colonysim.run("hard", seed=3, episodes=2, out=tmp_path / "run", attend=attend)
    opened = colonysim.Run.open(tmp_path / "run")
    assert opened.verify()
    assert opened.manifest["by_hand"] == [0, 1]
    assert opened.scenario.digest == run.scenario.digest
    assert [change.kind for change in opened.scenario.changes] == ["policy", "add_box"]
    again = colonysim.run(opened.scenario, seed=3, episodes=2, out=tmp_path / "again")
    assert again.trace_sha256 == run.trace_sha256 != colonysim.run("hard", seed=3, episodes=2, trace=False).trace_sha256
    repeated = colonysim.repeat(tmp_path / "run", out=tmp_path / "repeated")
    assert repeated.trace_sha256 == run.trace_sha256


def test_a_run_that_was_changed_by_hand_and_stopped_is_gone_on_with(tmp_path: Path) -> None:
    class StopError(Exception):
        pass

    def attend(stop_at: float) -> Any:
        def attended(colony: Colony, share: Any) -> None:
            count = len(colony.scenario.changes)
            if colony.episode == 1 and count < 3 and colony.now > 5.0 * (count + 1):
                colony.change([{"policy": {"beta": 0.5}}, {"add_box": {"node": 3, "height": 0.35}},
                               {"fail": {"agents": [1], "seconds": 5.0}}][count])  # fmt: skip
            if colony.episode == 1 and colony.now > stop_at:
                raise StopError

        return attended

    whole = colonysim.run("hard", seed=3, episodes=2, out=tmp_path / "whole", attend=attend(1e9))
    for every in (0.01, 1e9):  # from a checkpoint that may not know the last change, and from the beginning
        out = tmp_path / f"{every}"
        with pytest.raises(StopError):
            colonysim.run("hard", seed=3, episodes=2, out=out, attend=attend(18.0), checkpoint_every=every)
        assert colonysim.resume(out).trace_sha256 == whole.trace_sha256


def test_on_rigid_bodies_it_comes_to_the_same_and_no_box_can_come(engine: str, tmp_path: Path) -> None:
    scenario, sink = colonysim.load_scenario("sanity", None, {"max_steps": 12}), writer(2)
    with Colony(scenario, backend=engine, seed=3, episodes=2, sink=sink) as colony:
        go_to(colony, 1, 1.0)
        assert "add_box" not in colony.changeable
        with pytest.raises(ScenarioError, match="builds all bodies from the beginning: by hand none can come or go"):
            colony.change({"add_box": {"node": scenario.topology.ids[0], "height": 0.35}})
        colony.change({"policy": {"beta": 0.5, "exploration_half_life": 20.0}})
        go_to(colony, 1, 4.0)
        colony.change({"wipe": {"fields": ["D"]}})
        go_to(colony, 1, 7.0)
        colony.save(tmp_path / "colony.npz")
        fork, loaded = colony.fork(), Colony.load(tmp_path / "colony.npz")
        for _ in range(6):
            assert colony.step() is not None
        found, again = run_to_end(colony, sink), colony.scenario
        assert again.document["changes"][:2] == loaded.scenario.document["changes"]
        assert list(fork) == list(loaded)
    assert found == written(again, backend=engine, seed=3, episodes=2)
