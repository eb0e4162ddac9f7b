"""Agents that differ (`groups:`): radius, speed, pushing, policy, and the fields that they ignore."""

from __future__ import annotations

import dataclasses

import pytest
from small_worlds import SCENT, Script, Scripted, line, place, play

import colonysim
from colonysim.backends.mock import Mock
from colonysim.backends.protocol import Done
from colonysim.errors import ColonysimError, ScenarioError
from colonysim.policies.stigmergy import Stigmergy
from colonysim.policies.uniform import Uniform
from colonysim.scenario.groups import Group
from colonysim.scenario.invent import invent
from colonysim.testing.worlds import random_scenario
from colonysim.world.intents import Outcome, Push, Travel, Wait
from colonysim.world.state import World


def document(seed=3, *, agents=6, **fields):
    made = invent("grid", columns=8, rows=8, holes=2, spare=2, agents=agents, seed=seed)
    return {**made, **fields}


def grouped(seed=3, *groups, agents=6, **fields):
    """A level grid with boxes and holes whose agents are shared out among groups; the last takes who is left."""
    made = document(seed, agents=agents, **fields)
    starts = [int(n) for n in colonysim.scenario_from_document(made).agents]
    numbers = [colonysim.scenario_from_document(made).topology.ids[node] for node in starts]
    del made["agents"]
    made["groups"], first = [], 0
    for n, group in enumerate(groups):
        count = group.pop("count", 2) if n < len(groups) - 1 else len(numbers) - first
        made["groups"].append({"name": f"g{n}", "agents": numbers[first : first + count], **group})
        first += count
    return colonysim.scenario_from_document(made)


def sha(scenario, **options):
    return colonysim.run(scenario, trace=False, **{"seed": 1, "episodes": 3, **options}).trace_sha256


def pushers(events):
    return {event.agent for event in events if event.kind == "end" and event.action in ("push", "take")}


# -- numbering, and groups that differ in nothing --------------------------------------------------------------------


def test_agents_are_numbered_group_after_group_and_drawn_ones_are_free():
    made = document()
    del made["agents"]
    made["groups"] = [
        {"name": "drawn", "agents": {"count": 20, "seed": 4}}, {"name": "listed", "agents": [0, 1, 2]},
        {"name": "too", "agents": {"count": 15, "seed": 4}},
    ]  # fmt: skip
    scenario = colonysim.scenario_from_document(made)
    assert [group.agents for group in scenario.groups] == [range(20), range(20, 23), range(23, 38)]
    assert len(set(scenario.agents)) == 38 and scenario.agents[20:23] == (0, 1, 2)
    with colonysim.Colony(scenario) as colony:
        assert colony.agents.group.tolist() == ["drawn"] * 20 + ["listed"] * 3 + ["too"] * 15
    with colonysim.Colony("sanity") as colony:
        assert colony.agents.group.tolist() == [""]


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_groups_that_differ_in_nothing_are_agents_like_all(mode):
    plain = colonysim.scenario_from_document(document())
    same = grouped(3, {}, {"speed": 1.0, "detection_radius": plain.detection_radius, "policy": {"beta": 4.0}})
    assert sha(same, mode=mode) == sha(plain, mode=mode)


# -- pushing ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("policy", ["stigmergy", "paper", "oracle", "random"])
@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_who_does_not_push_never_does(policy, mode):
    pushed = set()
    for seed in range(6):
        scenario = grouped(seed, {"pushes": False, "count": 3}, {})
        pushed |= pushers(play(scenario, policy=policy, mode=mode, seed=seed, episodes=3)[0])
    assert pushed and pushed <= {3, 4, 5}


def test_a_policy_of_others_that_wants_to_is_refused():
    boxed = line(4, agents=[0], goal=3, boxes=[(1, 0.2)], max_steps=3)
    scenario = dataclasses.replace(boxed, groups=(Group("a", range(1), 5.0, pushes=False),))

    def act(agent, view, n):
        assert not view.pushes_boxes and view.nearest_box() is None and not view.graspable_from(0, 0)
        assert view.boxes() == [0] and list(view.feasible(0, [2])) == [0.0]
        return Push(0, 1, -1)

    for backend in ("nodeworld", Scripted(lambda agent, intent, now: Done(1.0, Outcome("arrived", intent.node)))):
        events, _ = play(scenario, policy=Script(act), backend=backend, episodes=1)
        ends = [(e.status, e.reason, e.now_at) for e in events if e.kind == "end"]
        assert ends == [("blocked", "does not push", 0)] * 3


# -- what they see ---------------------------------------------------------------------------------------------------


def test_each_group_has_its_radius_and_shares_what_it_is_looked_up_in():
    scenario = line(12, agents=[0, 1, 2, 3], goal=11, detection_radius=3.0)
    scenario = dataclasses.replace(
        scenario, groups=(Group("near", range(1), 1.0), Group("all", range(1, 2), 3.0), Group("far", range(2, 4), 6.0))
    )
    seen = {}

    def act(agent, view, n):
        seen.setdefault(agent, (view.radius, [node for node in range(12) if view.sees(node)]))
        return Wait((), 1.0)

    play(dataclasses.replace(scenario, time_limit=3.0), policy=Script(act), episodes=1)
    assert seen == {
        agent: (radius, [node for node in range(12) if abs(node - agent) <= radius])
        for agent, radius in enumerate((1.0, 3.0, 6.0, 6.0))
    }
    world = World(scenario)
    assert world.visibility_of(2) is world.visibility_of(3) is not world.visibility_of(0)
    assert world.visibility_of(1) is world.visibility() is world.visibility_of(-1)


def test_h_is_left_by_who_sees_the_hole():
    """A scout that sees a hole from afar leaves a mark where it stands, one who does not leaves none."""
    for radius, marked in ((2.0, False), (4.0, True)):
        scenario = line(9, agents=[1], goal=0, holes={5: (-1.0, 0.0)}, boxes=[(4, 1.0)], detection_radius=2.0)
        scenario = dataclasses.replace(scenario, groups=(Group("scouts", range(1), radius),))
        colony = colonysim.Colony(scenario, episodes=1)
        list(colony)
        assert (colony.fields["H"].at(1, 5) > 0.0) == marked


# -- how fast they are -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("backend", [None, "others"])
def test_who_is_faster_takes_less_time(backend):
    def answer(agent, intent, now):
        return Done(1.0, Outcome("arrived", intent.node))

    scenario = line(9, agents=[0, 8], goal=4)
    scenario = dataclasses.replace(
        scenario, groups=(Group("fast", range(1), 5.0, speed=2.0), Group("slow", range(1, 2), 5.0, speed=0.5))
    )
    steps = Script(lambda agent, view, n: Travel(view.node + (1 if agent == 0 else -1)))
    events, _ = play(scenario, policy=steps, backend="nodeworld" if backend is None else Scripted(answer), episodes=1)
    took = {(e.agent, e.time - e.began) for e in events if e.kind == "end"}
    assert took == {(0, 0.5), (1, 2.0)}


@pytest.mark.parametrize("backend", ["bullet", "mujoco", "mock"])
def test_with_a_clock_all_robots_are_alike(backend, tmp_path):
    if backend != "mock":
        pytest.importorskip({"bullet": "pybullet", "mujoco": "mujoco"}[backend])
    body = Mock(tick=0.1) if backend == "mock" else backend
    scenario = grouped(3, {"speed": 2.0}, {})
    with pytest.raises(ScenarioError, match=r"groups\.0\.speed: 2 is for backends without a clock"):
        colonysim.run(scenario, backend=body, episodes=1, out=tmp_path / "run")
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("backend", ["bullet", "mujoco"])
def test_groups_and_faults_on_rigid_bodies(backend):
    pytest.importorskip({"bullet": "pybullet", "mujoco": "mujoco"}[backend])
    hard = dict(colonysim.load_scenario("hard").document)
    starts = hard.pop("agents")
    hard["groups"] = [
        {"name": "scouts", "agents": starts[:2], "pushes": False, "detection_radius": 8.0, "ignores": ["E"]},
        {"name": "workers", "agents": starts[2:]},
    ]
    hard["faults"] = {"move_fails": 0.1, "box_missed": 0.1, "mark_noise": 0.1, "stops": {"every": 60, "seconds": 5}}
    scenario = colonysim.scenario_from_document(hard)
    events, _ = play(scenario, backend=backend, seed=1, episodes=1)
    assert pushers(events) <= {2, 3} and {"fault", "stopped"} <= {event.reason for event in events}
    assert play(scenario, backend=backend, seed=1, episodes=1)[0] == events


# -- policies and fields ---------------------------------------------------------------------------------------------


def fork(**fields):
    """Two ways to the goal, of the same length: over 1 or over 2."""
    return place(
        [(0.0, 0.0), (1.0, 1.0), (1.0, -1.0), (2.0, 0.0)], [(0, 1), (0, 2), (1, 3), (2, 3)], goal=3, agents=[0],
        **fields,
    )  # fmt: skip


def share_over_1(group, **parameters):
    scenario = fork(parameters=parameters)
    scenario = dataclasses.replace(scenario, groups=(dataclasses.replace(group, agents=range(1)),))
    events, _ = play(scenario, episodes=60, seed=1)
    first = [e.target for e in events if e.kind == "end" and e.node == 0 and e.step == 1]
    return first.count(1) / len(first)


def test_a_group_weighs_a_field_of_its_own_or_the_scenarios_otherwise():
    own = {"extra_fields": [SCENT], "weights": {"A": 3.0}}
    plain = Group("a", range(1), 5.0)
    assert 0.2 < share_over_1(plain) < 0.8
    assert share_over_1(dataclasses.replace(plain, parameters=own)) > 0.9
    assert share_over_1(dataclasses.replace(plain, parameters={"weights": {"A": -3.0}}), **own) < 0.1
    assert share_over_1(dataclasses.replace(plain, parameters={"weights": {}}), **own) < 0.8


def test_a_group_reads_its_fields_and_all_leave_marks_in_all_of_them():
    scenario = grouped(3, {"policy": {"extra_fields": [SCENT]}}, {})
    colony = colonysim.Colony(scenario, episodes=1)
    assert set(colony.fields) == {"D", "B", "H", "E", "A"}


def test_who_ignores_a_field_reads_it_unmarked_and_leaves_marks_in_it():
    read = {0: [], 1: []}

    class Reader(Stigmergy):
        def decide(self, view, memory, random):
            d, e, h = (view.fields[name] for name in "DEH")
            read[view.agent].append([(d.at(j), e.at(j), tuple(h.keys(j))) for j in view.neighbours])
            return super().decide(view, memory, random)

    scenario = grouped(3, {"ignores": ["D", "E", "H"], "count": 1}, {}, agents=2)
    colony = colonysim.Colony(scenario, policy=Reader, episodes=4, seed=1)
    list(colony)
    policy, world = Stigmergy(scenario), World(scenario)
    unmarked = policy.fields(world)
    blank = {unmarked["D"].at(node) for node in range(len(world.top))}
    assert all(e == 0.0 and keys == () and d in blank for near in read[0] for d, e, keys in near)
    assert any(e > 0.0 for near in read[1] for _, e, _ in near)
    assert any(keys for near in read[1] for _, _, keys in near)
    alone = colonysim.Colony(grouped(3, {"ignores": ["E"], "count": 1}, {}, agents=2), policy=Reader, episodes=1)
    while not any(event.kind == "end" and event.agent == 0 for event in [alone.step()]):
        pass
    assert alone.fields["E"].at(int(alone.agents.node[0])) > 0.0


def test_a_minority_that_ignores_what_others_heed():
    """Who heeds E spreads out at first; who ignores all marks goes by the straight line alone."""
    heed, ignore = (grouped(5, {"ignores": some, "count": 5}, {}) for some in ([], ["D", "B", "H", "E"]))
    assert sha(heed) != sha(ignore)


def test_policies_of_others_in_a_group_beside_ours():
    scenario = grouped(3, {"policy": f"{__name__}:Shy", "count": 2}, {"policy": "random", "count": 2}, {})
    events, rows = play(scenario, seed=1, episodes=2)
    assert {e.action for e in events if e.agent in (0, 1) and e.kind in ("wait", "end")} == {"wait"}
    assert {e.action for e in events if e.agent in (2, 3) and e.kind == "end"} > {"travel"}
    assert {row[2] for row in rows.tables["deposits"]} == {"D", "E", "H", "B"}


class Shy(Uniform):
    """Waits."""

    name = "shy"

    def decide(self, view, memory, random):
        from colonysim.policies.policy import Choice

        return Choice(Wait((), 5.0), memory)


def test_with_another_policy_for_all_the_parameters_of_groups_hold():
    scenario = grouped(3, {"policy": {"beta": 0.0}}, {})
    assert sha(scenario, policy="oracle") != sha(grouped(3, {}, {}), policy="oracle")
    assert sha(scenario, policy=Stigmergy) == sha(scenario)
    with pytest.raises(ColonysimError, match="group 'g0' has parameters of its own"):
        sha(scenario, policy=Stigmergy(scenario))


@pytest.mark.parametrize(
    ("group", "words"),
    [({"policy": {"d_max": 3.0}}, r"groups\.0\.policy\.d_max: .* belongs to the fields"),
     ({"policy": {"preset": "paper"}}, r"groups\.0\.policy: distance_rule is 'literal' here"),
     ({"policy": {"bta": 3.0}}, r"groups\.0\.policy\.bta: no such parameter; did you mean 'beta'"),
     ({"policy": {"weights": {"D": 0.0}}}, r"groups\.0\.policy\.weights\.D: no extra field 'D'.*`ignores`"),
     ({"ignores": ["d"]}, r"groups\.0\.ignores\.0: no field 'd'; did you mean 'D'"),
     ({"policy": "colny"}, r"groups\.0\.policy\.name: no policy 'colny'; did you mean 'colony'")],
)  # fmt: skip
def test_what_cannot_be(group, words):
    with pytest.raises(ScenarioError, match=words):
        sha(grouped(3, group, {}))


# -- told apart ------------------------------------------------------------------------------------------------------


def test_success_and_steps_of_each_group(tmp_path):
    for seed in range(5):
        scenario = grouped(seed, {"speed": 3.0}, {"pushes": False, "count": 1}, {}, max_steps=30)
        kept = colonysim.run(scenario, seed=seed, episodes=3, out=tmp_path / str(seed))
        bare = colonysim.run(scenario, seed=seed, episodes=3, trace=False)
        read = colonysim.Run.open(tmp_path / str(seed))
        assert kept.groups == bare.groups == read.groups and len(read.groups) == 9
        for result in read.episodes:
            own = [group for group in read.groups if group.episode == result.episode]
            assert sum(g.success * g.agents for g in own) == pytest.approx(result.success * 6)
            assert max(g.steps for g in own) == result.steps
        assert read.scenario.groups == scenario.groups
    assert colonysim.run("sanity", episodes=1, trace=False).groups == []


def test_of_random_worlds():
    """Groups of all kinds together: whoever is not to push does not, and runs are the same again."""
    for seed in range(60):
        made = dict(random_scenario(seed, max_nodes=30, max_agents=6).document)
        starts = made.pop("agents")
        made["groups"] = [
            {"name": str(n), "agents": [start], "pushes": n % 2 == 0, "speed": 1.0 + n, "detection_radius": 1.0 + n,
             "ignores": ["D", "B", "H", "E"][n % 5 :], "policy": {"beta": 1.0 + n}}
            for n, start in enumerate(starts)
        ]  # fmt: skip
        scenario = colonysim.scenario_from_document(made)
        mode = ("asynchronous", "synchronous")[seed % 2]
        events, _ = play(scenario, seed=seed, mode=mode, episodes=2)
        assert not any(agent % 2 for agent in pushers(events))
        assert play(scenario, seed=seed, mode=mode, episodes=2)[0] == events
