"""What outlives an episode, and what a run can take over from another."""

from __future__ import annotations

import pytest
from small_worlds import line, play, visit

import colonysim
from colonysim import load_scenario
from colonysim.errors import ColonysimError
from colonysim.pheromones import BoxWorth, Distance, Exploration, HoleTrail
from colonysim.policies.stigmergy import Memory, Stigmergy
from colonysim.trace.schema import Frame
from colonysim.world.state import AgentStatus, World


class Watched(Stigmergy):
    """Notes what its agents remember, and how the world stands, at the start of each episode."""

    def __init__(self, scenario) -> None:
        super().__init__(scenario)
        self.began: list[tuple] = []

    def fields(self, world):
        self.world, self.own = world, super().fields(world)
        return self.own

    def begin(self, agent, memory):
        world = self.world
        state = (
            list(world.surface), list(world.box_node), list(world.box_claim), list(world.agent_node),
            list(world.agent_box), list(world.agent_from), list(world.agent_status), list(world.occupant),
            list(world.reserved), dict(world.clear_requests),
        )  # fmt: skip
        self.began.append((agent, memory, state))
        return super().begin(agent, memory)


class Loaded(Watched):
    """Stops the run right before the first episode, when its fields hold what was loaded."""

    def begin(self, agent, memory):
        raise KeyboardInterrupt


def test_pheromones_and_epsilon_persist_and_everything_else_begins_anew(backend):
    scenario = load_scenario("medium", None, {"max_steps": 12})
    policy = Watched(scenario)
    _, rows = play(scenario, policy=policy, backend=backend, episodes=3, seed=1)
    states = [state for _, _, state in policy.began]
    assert len(states) == 3 * len(scenario.agents) and all(state == states[0] for state in states)
    assert states[0][6] == [AgentStatus.ACTIVE] * len(scenario.agents)
    later = [memory for _, memory, _ in policy.began[len(scenario.agents) :]]
    assert all(isinstance(memory, Memory) for memory in later)
    frames = {n: {(f.field, f.node, f.key): f.value for f in rows.tables["frames"] if f.episode == n} for n in (1, 2)}
    kept = [place for place in frames[1] if place[0] == "D" and place in frames[2]]
    assert len(kept) > 10
    first = {(d[2], d[4], d[5]): d[6] for d in reversed(rows.tables["deposits"]) if d[0] == 2 and d[2] == "E"}
    for (_, node, key), value in first.items():
        assert value == pytest.approx(0.5 * frames[1].get(("E", node, key), 0.0) + 1.0)


def test_a_fresh_memory_keeps_only_the_chance_to_explore():
    policy = Stigmergy(load_scenario("sanity"))
    assert policy.begin(0, None) == Memory(0.2)
    assert policy.begin(0, Memory(0.2, box=1, hole=0, shunned=1, shunned_at=3)) == Memory(0.2 * 0.8)
    assert policy.begin(0, Memory(0.011)) == Memory(0.01)


@pytest.mark.parametrize("preset", ["colony", "paper"])
def test_a_run_from_another_s_pheromones_begins_as_its_next_episode_would(tmp_path, preset):
    scenario = load_scenario("medium", None, {"policy.preset": preset})
    first = colonysim.run(scenario, episodes=3, seed=1, out=tmp_path / "first")
    watched = Loaded(scenario)
    with pytest.raises(KeyboardInterrupt):
        colonysim.run(scenario, policy=watched, initial=first, trace=False)
    holes = [scenario.topology.ids[hole.node] for hole in scenario.holes]
    least = min(first.field("E").values()) if len(first.field("E")) == len(scenario.topology) else 0.0
    after = {  # what the end of an episode does
        "D": float, "B": float,
        "H": lambda value: 0.5 * value if preset == "colony" else 0.0,
        "E": lambda value: 0.5 * value if preset == "colony" else value - least,
    }  # fmt: skip
    for name, aged in after.items():
        there = first.field(name)
        assert there, name
        field = watched.own[name]
        for place, value in there.items():
            node, hole = place if isinstance(place, tuple) else (place, -1)
            found = field.at(
                node if field.by_box else scenario.topology.index[node], holes.index(hole) if hole >= 0 else -1
            )
            assert found == pytest.approx(aged(value), rel=1e-12), (name, place)
    again = colonysim.run(scenario, episodes=2, seed=2, initial=tmp_path / "first", trace=False)
    blank = colonysim.run(scenario, episodes=2, seed=2, trace=False)
    assert again.trace_sha256 != blank.trace_sha256
    assert again.manifest["options"]["initial"] == str(tmp_path / "first")


@pytest.mark.parametrize("make", [
    lambda world: Distance(world, d_max=20.0), lambda world: Distance(world, d_max=20.0, rule="literal"),
    lambda world: BoxWorth(world, start=40.0), HoleTrail, Exploration,
    lambda world: Exploration(world, evaporation=None),
])  # fmt: skip
def test_what_a_field_frames_it_loads(make):
    world = World(line(6, goal=5, agents=[0], holes={2: (-1.0, 0.0), 4: (-1.0, 0.0)}, boxes=[(1, 1.0)],
                       detection_radius=1.2))  # fmt: skip
    field = make(world)
    for node in (5, 0, 3, 5, 1, 3):
        field.deposit(visit(world, node))
        field.deposit(visit(world, node, "claim", box=0, hole=1))
    field.end_episode()
    for node in (0, 3):
        field.deposit(visit(world, node))
    other = make(world)
    other.load(field.frame())
    assert [(w.node, w.key) for w in other.frame()] == [(w.node, w.key) for w in field.frame()]
    assert [w.value for w in other.frame()] == pytest.approx([w.value for w in field.frame()], rel=1e-14)
    field.end_episode()
    other.end_episode()
    assert [w.value for w in other.frame()] == pytest.approx([w.value for w in field.frame()], rel=1e-14)


def test_a_loaded_distance_remembers_which_nodes_were_official():
    """Also where the way to the goal is the straight line, so that the value alone does not tell."""
    world = World(line(4, goal=3, agents=[0]))
    field = Distance(world, d_max=10.0, rule="literal")
    for node in (3, 2, 1):
        field.deposit(visit(world, node))
    other = Distance(world, d_max=10.0, rule="literal")
    other.load(field.frame())
    assert list(other.official) == list(field.official) == [False, True, True, True]


def test_frames_of_another_map_are_refused():
    scenario = load_scenario("sanity")
    for frame in (Frame(1, "D", 77, -1, 3.0), Frame(1, "H", 0, 5, 0.5)):
        with pytest.raises(ColonysimError, match="no such node"):
            play(scenario, initial={frame.field: [frame]})
    for value in (float("nan"), float("inf")):
        for name in "DHE":
            with pytest.raises(ColonysimError, match=f"run's {name} holds {value} at 0, expected a finite number"):
                play(scenario, initial={name: [Frame(1, name, 0, -1, value)]})
    with pytest.raises(ColonysimError, match="no such box"):
        play(scenario, initial={"B": [Frame(1, "B", 10**6, -1, 1.0)]})
    unknown = {"unknown": [Frame(1, "unknown", 99, -1, 1.0)]}
    play(scenario, initial={"D": [Frame(1, "D", 0, -1, 3.0)], **unknown}, episodes=1)
    for policy in (None, "random"):
        with pytest.raises(ColonysimError, match="unknown to start with: this policy would not see them"):
            play(scenario, initial=unknown, policy=policy, episodes=1)
