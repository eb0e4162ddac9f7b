"""The timeline of a scenario: what changes while a colony is under way."""

import random

import pytest

import colonysim
from colonysim.backends.mock import Mock
from colonysim.backends.nodeworld import NodeWorld
from colonysim.errors import ColonysimError, ScenarioError
from colonysim.plots import draw
from colonysim.scenario.loading import scenario_from_document
from colonysim.testing.timelines import random_changes
from colonysim.testing.worlds import random_document
from colonysim.video import write_video
from colonysim.view import write_page


def line(*changes, nodes=5, **more):
    """Agents on a line; the goal is its end."""
    document = {
        "nodes": [[i, 2.0 * i, 0.0] for i in range(nodes)],
        "edges": [[i, i + 1] for i in range(nodes - 1)],
        "agents": [0],
        "goal": nodes - 1,
        "episodes": 1,
        "max_steps": 1000,
        "changes": list(changes),
        **more,
    }
    return scenario_from_document(document, source="line")


def events(scenario, **more):
    return list(colonysim.simulate(scenario, **more))


def at(kind, found, action=""):
    return [event for event in found if event.kind == kind and (not action or event.action == action)]


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_an_edge_that_goes_is_not_travelled_until_it_comes_back(backend, mode):
    scenario = line({"remove_edge": [2, 3]}, {"time": 200.0, "add_edge": [2, 3]})
    found = events(scenario, backend=backend, mode=mode, seed=1)
    crossed = [event for event in at("end", found) if {event.node, event.now_at} == {2, 3}]
    assert found[-1].status == "goal"
    assert crossed
    assert all(event.began >= 200.0 for event in crossed)
    assert at("change", found, "add_edge")[0].time == 200.0


def test_an_edge_that_comes_joins_nodes_that_had_none():
    found = events(line({"time": 3.0, "add_edge": [0, 4]}, {"remove_edge": [0, 1]}), seed=1)
    assert [(event.node, event.now_at) for event in at("end", found)] == [(0, 4)]


def test_agents_go_to_where_the_goal_is_now(backend):
    found = events(line({"time": 0.5, "move_goal": 1}), backend=backend, seed=2)
    assert [event.node for event in at("goal", found)] == [1]


def test_an_agent_that_waits_on_the_new_goal_is_there():
    scenario = line({"remove_edge": [0, 1]}, {"time": 30.0, "move_goal": 0})
    found = events(scenario)
    assert (at("goal", found)[0].time, found[-1].status) == (30.0, "goal")


def test_a_box_appears_where_nobody_is_and_fills_the_hole(backend):
    hole = {"holes": [{"node": 3, "depth": 0.35}], "boxes": []}
    found = events(line({"time": 20.0, "add_box": {"node": 2, "height": 0.35}}, **hole), backend=backend, seed=3)
    (appeared,) = at("change", found, "add_box")
    assert (appeared.box, appeared.node) == (0, 2)
    assert appeared.time >= 20.0
    assert any(event.box == 0 and event.status == "arrived" for event in at("end", found, "push"))
    assert found[-1].status == "goal"


def test_a_box_that_disappears_leaves_its_node_free(backend):
    scenario = line({"time": 0.5, "remove_box": 0}, boxes=[[2, 0.7]])
    with colonysim.Colony(scenario, backend=backend, seed=1) as colony:
        colony.run_until(time=0.4)
        assert (colony.boxes.node.tolist(), colony.world.surface[2]) == ([2], 0.7)
        colony.run_until(event="change")
        assert colony.boxes.node.tolist() == [-1]
        assert colony.world.surface.tolist() == [0.0] * 5
        assert colony.run_until(episode=1).status == "goal"


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_an_agent_joins_once_its_node_is_free(backend, mode):
    with colonysim.Colony(line({"time": 0.2, "add_agent": 0}), backend=backend, mode=mode, seed=1) as colony:
        colony.step()
        assert colony.agents.status.tolist() == ["active", "absent"]
        first = colony.run_until(event=lambda event: event.kind == "start" and event.agent == 1)
        assert colony.agents.node[0] == 1
        assert first.time > 0.2
        colony.run_until(episode=1)
        assert colony.agents.status.tolist() == ["goal", "goal"]


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_who_fails_is_lost_where_it_stands(backend, mode):
    found = events(line({"time": 1.0, "fail": {"agents": [0]}}), backend=backend, mode=mode, seed=1)
    (lost,) = at("lost", found)
    assert lost.node == 1
    assert found[-1].status == "lost"


def test_who_fails_while_it_waits_is_lost_at_once_and_lets_go_of_its_box():
    scenario = line({"time": 40.0, "fail": {"agents": [0]}}, {"remove_edge": [0, 1]})
    (lost,) = at("lost", events(scenario))
    assert lost.time == 40.0


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_who_fails_for_a_while_goes_on_afterwards(mode):
    found = events(line({"time": 1.0, "fail": {"agents": [0], "seconds": 50.0}}), mode=mode)
    begun = [event.began for event in at("end", found)]
    assert begun[1] >= 51.0
    assert found[-1].status == "goal"


def test_a_change_waits_for_its_condition():
    changes = {"when": {"at_goal": 1}, "move_goal": 0}
    found = events(line(changes, agents=[3, 2]), seed=1)
    (moved,) = at("change", found)
    assert moved.time == at("goal", found)[0].time
    assert [event.node for event in at("goal", found)] == [4, 0]


def test_a_change_waits_for_a_hole_to_be_filled():
    hole = {"holes": [{"node": 2, "depth": 0.35}], "boxes": [[1, 0.35]]}
    scenario = line({"when": {"filled": 2}, "remove_edge": [0, 1]}, **hole)
    found = events(scenario, seed=1)
    (gone,) = at("change", found)
    filled = next(event for event in at("end", found, "push") if event.target == 2 and event.status == "arrived")
    assert gone.time == filled.time


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_it_happens_before_whoever_made_it_happen_decides(mode):
    hole = {"holes": [{"node": 2, "depth": 0.35}], "boxes": [[1, 0.35]], "max_steps": 20}
    found = events(line({"when": {"filled": 2}, "remove_edge": [1, 2]}, **hole), seed=1, mode=mode)
    (gone,) = at("change", found)
    assert not [event for event in at("end", found) if event.began >= gone.time and event.target == 2]


def test_changes_belong_to_their_episodes():
    changes = [
        {"episode": 2, "add_edge": [0, 4]},
        {"from_episode": 3, "add_edge": [0, 3]},
        {"to_episode": 1, "add_edge": [0, 2]},
    ]
    found = events(line(*changes, episodes=4))
    assert [(event.episode, event.target) for event in at("change", found)] == [(1, 2), (2, 4), (3, 3), (4, 3)]


def test_marks_are_wiped_away():
    scenario = line({"time": 5.0, "wipe": {"fields": ["E"], "within": [0, 0, 2, 0]}}, {"time": 6.0, "wipe": {}})
    with colonysim.Colony(scenario) as colony:
        colony.run_until(time=4.99)
        before = colony.fields["E"].values()
        assert (before[:2] > 0).all()
        colony.run_until(time=5.0)
        assert colony.fields["E"].values()[:2].tolist() == [0.0, 0.0]
        assert colony.fields["E"].values()[2] == before[2]
        assert colony.fields["D"].items()
        colony.run_until(time=6.0)
        assert not any(field.items() for field in colony.fields.values())


def test_a_surface_that_sinks_is_a_step_and_what_stands_there_sinks_along():
    scenario = line({"time": 0.5, "set_surface": {"node": 2, "z": -0.5}}, boxes=[[2, 0.5]], no_push=[[2, 3], [2, 1]])
    with colonysim.Colony(scenario) as colony:
        colony.run_until(time=0.5)
        assert colony.world.surface[2] == 0.0
        assert colony.boxes.base[0] == -0.5
        assert colony.run_until(episode=1).status == "goal"


def test_a_slope_leans_as_its_nodes_say():
    scenario = line({"set_surface": {"node": 4, "z": 0.9}}, nodes=5, slopes=[[3, 4]])
    assert events(scenario)[-1].status == "goal"


def test_a_change_outlasts_the_stall():
    scenario = line({"remove_edge": [0, 1]}, {"time": 5000.0, "add_edge": [0, 1]}, stall_seconds=60.0)
    found = events(scenario)
    assert found[-1].status == "goal"
    assert found[-1].time > 5000.0


def test_who_never_joins_in_an_episode_takes_no_part_in_it():
    runs = colonysim.run(line({"episode": 2, "time": 1.0, "add_agent": 3}, episodes=2), trace=False)
    assert [(result.success, result.ended) for result in runs.episodes] == [(1.0, "goal"), (1.0, "goal")]


def test_who_has_not_joined_yet_sees_nothing_and_belongs_to_no_group():
    more = {"agents": None, "groups": [{"name": "first", "agents": [0, 1]}]}
    document = {**line({"time": 500.0, "add_agent": 3}).document, **more}
    with colonysim.Colony(scenario_from_document({k: v for k, v in document.items() if v is not None})) as colony:
        colony.step()
        assert colony.agents.group.tolist() == ["first", "first", ""]
        assert colony.agents.status.tolist() == ["active", "active", "absent"]
        assert colony.view(1).node == 1
        with pytest.raises(ColonysimError, match="agent 2 is not there"):
            colony.view(2)


def test_a_backend_is_told_of_what_changes_after_its_reset():
    class Told(NodeWorld):
        def reset(self, world, streams):
            super().reset(world, streams)
            self.world, self.heard = world, [("reset", world.goal)]

        def changed(self, change):
            self.heard.append((change.kind, self.world.goal))

    body = Told()
    changes = [{"move_goal": 1}, {"time": 0.1, "move_goal": 2}, {"time": 0.2, "wipe": {"fields": ["D"]}}]
    with colonysim.Colony(line(*changes), backend=body) as colony:
        colony.run_until(time=0.3)
        assert body.heard == [("reset", 1), ("move_goal", 2), ("wipe", 2)]


@pytest.mark.parametrize("change", ["set_surface", "add_box"])
def test_a_backend_that_cannot_follow_refuses(change):
    what = {"set_surface": {"node": 1, "z": 1.0}, "add_box": {"node": 1, "height": 1.0}}[change]
    backend = Mock() if change == "add_box" else "physics"
    with pytest.raises(ScenarioError, match=rf"changes.0.{change}: backend .* cannot follow this, expected add_edge"):
        events(line({change: what}), backend=backend)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({}, r"changes.0: says not what happens, expected one of add_edge"),
        ({"add_edge": [0, 2], "move_goal": 1}, r"changes.0.move_goal: stands beside `add_edge`"),
        ({"remove_edge": [0, 2]}, r"changes.0.remove_edge: 0-2 is no edge"),
        ({"add_edge": [0, 9]}, r"changes.0.add_edge.1: there is no node 9.*did you mean 4"),
        ({"add_edge": [1, 1]}, r"changes.0.add_edge: joins node 1 with itself"),
        ({"remove_box": 0}, r"changes.0.remove_box: there is no box 0, there is none"),
        ({"fail": {"agents": [1]}}, r"changes.0.fail.agents.0: there is no agent 1, expected 0 to 0"),
        ({"when": {}, "move_goal": 1}, r"changes.0.when: expected exactly one of filled"),
        ({"when": {"filled": 1}, "move_goal": 1}, r"changes.0.when.filled: node 1 is no hole"),
        ({"when": {"at_goal": 2}, "move_goal": 1}, r"changes.0.when.at_goal: 2 agents, but there are only 1"),
        ({"episode": 1, "from_episode": 1, "move_goal": 1}, r"changes.0.from_episode: stands beside `episode`"),
        ({"from_episode": 3, "to_episode": 2, "move_goal": 1}, r"changes.0.to_episode: 2 is before from_episode 3"),
        ({"add_box": {"node": 4, "height": 1.0}}, r"changes.0.add_box.node: a box appears on the goal"),
        ({"wipe": {"within": [50, 50, 60, 60]}}, r"changes.0.wipe.within: there is no node within"),
        ({"remove_edg": [0, 1]}, r"changes.0.remove_edg: unknown field; did you mean 'remove_edge'"),
        ({"time": -1, "move_goal": 1}, r"changes.0.time: got -1, expected at least 0"),
        ({"add_edge": [0]}, r"changes.0.add_edge: a value is missing, expected \[from, to\]"),
    ],
)
def test_what_cannot_be_is_refused(change, words):
    with pytest.raises(ScenarioError, match=words):
        line(change)


def test_a_field_that_there_is_not_is_refused():
    with pytest.raises(ScenarioError, match=r"changes.0.wipe.fields.0: the policy has no field 'Q'"):
        events(line({"wipe": {"fields": ["Q"]}}))


def with_timeline(seed):
    rng = random.Random(seed)
    document = random_document(rng)
    return scenario_from_document({**document, "changes": random_changes(rng, document)}, source=f"timeline {seed}")


@pytest.mark.parametrize("policy", ["colony", "paper", "random"])
@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_random_timelines_run_to_the_end_of_every_episode(policy, mode):
    for seed in range(25):
        found = events(with_timeline(seed), policy=policy, mode=mode, seed=seed)
        assert [event.episode for event in at("episode", found)] == [1, 2, 3]


def test_a_timeline_that_does_nothing_changes_nothing():
    document = random_document(random.Random(5))
    plain = events(scenario_from_document(document, source="plain"), seed=5)
    later = {**document, "changes": [{"time": 1e6, "add_edge": document["edges"][0]}]}
    assert [event[:10] for event in events(scenario_from_document(later, source="later"), seed=5)] == [
        event[:10] for event in plain
    ]


def test_what_comes_of_a_timeline_can_be_read_plotted_and_shown(tmp_path):
    changes = [
        {"time": 5.0, "add_box": {"node": 2, "height": 0.35}}, {"time": 6.0, "add_agent": 0},
        {"time": 8.0, "move_goal": 3},
        {"time": 4.0, "add_edge": [0, 3]}, {"time": 9.0, "fail": {"agents": [1]}}, {"time": 9.5, "remove_box": 0},
        {"time": 2.0, "set_surface": {"node": 4, "z": 0.9}},
    ]  # fmt: skip
    made = colonysim.run(line(*changes, boxes=[[1, 0.35]], episodes=2), out=tmp_path / "run", seed=1)
    run = colonysim.Run.open(made.path)
    happened = {event.action for event in run.events(1) if event.kind == "change"}
    assert happened == {next(iter({*change} - {"time"})) for change in changes}
    assert draw(run, what=["map", "trajectories", "fates"])
    assert write_page(run).stat().st_size
    assert write_video(run, tmp_path / "run.gif", seconds=1, fps=5).stat().st_size


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_a_colony_with_a_timeline_can_be_saved_at_any_moment(mode, tmp_path):
    for seed in range(12):
        rng, scenario = random.Random(seed), with_timeline(seed)
        whole = list(colonysim.Colony(scenario, mode=mode, seed=seed))
        colony = colonysim.Colony(scenario, mode=mode, seed=seed)
        before = [colony.step() for _ in range(rng.randrange(len(whole)))]
        colony.save(tmp_path / "colony.npz")
        assert before + list(colonysim.Colony.load(tmp_path / "colony.npz")) == whole


def test_a_goal_that_has_moved_is_known_to_who_ignores_d(tmp_path):
    groups = {"groups": [{"name": "all", "agents": [0], "ignores": ["D"]}], "agents": None}
    scenario = line({"move_goal": 2}, nodes=5, **groups)
    whole = list(colonysim.Colony(scenario, seed=1))
    colony = colonysim.Colony(scenario, seed=1)
    before = [colony.step() for _ in range(2)]
    assert before + list(colony.fork()) == whole
