"""New worlds: valid, the same for the same seed, and solved by the boxes that come with them."""

from __future__ import annotations

import random
from collections import deque

import pytest
from typer.testing import CliRunner

import colonysim
from colonysim.cli import app
from colonysim.errors import ColonysimError, ScenarioError
from colonysim.scenario.invent import invent, to_yaml
from colonysim.scenario.loading import load_scenario
from colonysim.world.intents import BoxPlace, Outcome, Push
from colonysim.world.state import World

WORLDS = [
    {"kind": "grid", "columns": 20, "rows": 12, "holes": 6, "spare": 5, "agents": 9},
    {"kind": "grid", "columns": 30, "rows": 30, "holes": 10, "depth": 3, "agents": 60, "crowded": True},
    {"kind": "rooms", "columns": 3, "rows": 2, "size": 8, "holes": 5, "depth": 2, "agents": 12, "crowded": True},
    {"kind": "rooms", "columns": 1, "rows": 4, "size": 2, "agents": 3},
    {"kind": "platforms", "columns": 3, "rows": 3, "size": 5, "agents": 4},
    {"kind": "platforms", "columns": 2, "rows": 3, "size": 8, "depth": 2, "spare": 6, "agents": 20},
    {"kind": "geometric", "columns": 12, "rows": 9, "agents": 7},
]


def reached(world, starts):
    """All nodes that agents from there could travel to now."""
    seen, waiting = set(starts), deque(starts)
    while waiting:
        i = waiting.popleft()
        for j in world.topology.neighbours[i]:
            if j not in seen and world.reachable(i, j):
                seen.add(j)
                waiting.append(j)
    return seen


def way_into(world, box, hole):
    """A way on which the box can be pushed into the hole as things are, or None."""
    start, base = world.box_node[box], world.box_base[box]
    came, waiting = {start: start}, deque([start])
    while waiting:
        i = waiting.popleft()
        for j in world.topology.neighbours[i]:
            if j in came or not world.can_slide(base, i, j):
                continue
            came[j] = i
            if j == hole:
                way = [hole]
                while way[-1] != start:
                    way.append(came[way[-1]])
                return way[::-1]
            if not world.falls(base, i, j):
                waiting.append(j)
    return None


def solve(scenario):
    """Fills hole after hole with a box that can be reached; whether the goal can be reached in the end."""
    world = World(scenario)
    while True:
        free = reached(world, scenario.agents)
        if scenario.goal in free:
            return True
        for hole in sorted(scenario.holes, key=lambda h: (h.node not in world.stacks, h.node)):  # the begun ones first
            if world.surface[hole.node] > hole.rim - scenario.reach:
                continue
            near = [
                box for box, at in enumerate(world.box_node)
                if at != hole.node and free & set(world.topology.neighbours[at])
            ]  # fmt: skip
            ways = [(way, box) for box in near if (way := way_into(world, box, hole.node))]
            if ways:
                way, box = min(ways, key=lambda pair: len(pair[0]))
                places = (BoxPlace(box, hole.node),)
                world.apply(0, Push(box, way[-1], -1), Outcome("arrived", world.agent_node[0], places))
                break
        else:
            return False


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("wanted", WORLDS, ids=lambda wanted: f"{wanted['kind']}-{wanted['columns']}x{wanted['rows']}")
def test_a_new_world_can_be_solved_with_its_own_boxes(wanted, seed, tmp_path):
    document = invent(**wanted, seed=seed)
    path = tmp_path / "new.yaml"
    path.write_text(to_yaml(document))
    scenario = load_scenario(path)
    assert len(scenario.agents) == wanted["agents"]
    depth = wanted.get("depth", 1)
    assert len(scenario.boxes) >= wanted.get("holes", 0) * depth + wanted.get("spare", 0)
    assert solve(scenario)
    assert document == invent(**wanted, seed=seed)
    assert seed == 0 or document != invent(**wanted, seed=0)


def test_platforms_are_cut_off_from_each_other_until_holes_are_filled():
    scenario = colonysim.scenario_from_document(invent("platforms", columns=2, rows=2, size=5))
    free = reached(World(scenario), scenario.agents)
    assert len(free) == 25 - 2 and scenario.goal not in free, "the first platform without its two boxes"


def test_a_colony_solves_new_platforms():
    scenario = colonysim.scenario_from_document(invent("platforms", columns=2, rows=2, size=5, seed=3))
    run = colonysim.run(scenario, episodes=12, seed=5, trace=False)
    assert max(episode.success for episode in run.episodes) == 1.0


def test_rooms_have_walls_and_one_door_between_each_two():
    place = colonysim.scenario_from_document(invent("rooms", columns=3, rows=2, size=4)).topology
    assert len(place) == 3 * 2 * 16 + 7
    assert place.edge_count == 6 * 24 + 7 * 2


def test_a_crowd_is_drawn_from_free_nodes_within_its_borders():
    def agents(**crowd):
        document = invent("grid", columns=8, rows=8, holes=2) | {"agents": {"seed": 1, **crowd}}
        scenario = colonysim.scenario_from_document(document)
        taken = {scenario.goal, *(h.node for h in scenario.holes), *(b.node for b in scenario.boxes)}
        assert not taken & set(scenario.agents) and len(set(scenario.agents)) == len(scenario.agents)
        return scenario.agents

    assert agents(count=59) and agents(count=5) != agents(count=5, seed=2)
    assert all(node % 8 < 2 and node < 16 for node in agents(count=3, within=[0, 0, 1, 1]))
    with pytest.raises(ScenarioError, match=r"agents\.count: 60 agents, but only 59 nodes are free"):
        agents(count=60)
    with pytest.raises(ScenarioError, match="within these borders"):
        agents(count=5, within=[0.0, 0.0, 1.0, 1.0])
    with pytest.raises(ScenarioError, match=r"agents\.count"):
        agents(count=0)


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        ({"kind": "platforms", "size": 4}, "size: 4, expected a whole number from 5"),
        ({"kind": "platforms", "holes": 2}, "are their doors"),
        ({"kind": "platforms", "size": 5, "depth": 3}, "no room for so many boxes"),
        ({"kind": "platforms", "spare": 500}, "room for 9 spare boxes"),
        ({"kind": "grid", "columns": 8, "rows": 8, "holes": 5}, "need 5 squares"),
        ({"kind": "grid", "columns": 8, "rows": 8, "holes": 1, "depth": 4}, "at most 3 boxes deep"),
        ({"kind": "grid", "agents": 12, "crowded": True}, "12 agents, but only 8 nodes are free"),
        ({"kind": "geometric", "holes": 1}, "without holes"),
        ({"kind": "grid", "size": 5}, "rooms and platforms have one"),
        ({"kind": "grid", "depth": 2}, "there are no holes"),
        ({"kind": "platforms", "columns": 1, "rows": 1, "depth": 2}, "there are no holes"),
        ({"kind": "grid", "columns": 1, "rows": 1, "agents": 1}, "only 0 nodes are free"),
        ({"kind": "platforms", "agents": 99, "crowded": True}, "within these borders"),
        ({"kind": "grid", "columns": 10**9, "rows": 10**9}, "expected at most 2000000"),
        ({"kind": "platforms", "columns": 10**9, "rows": 10**9, "size": 10**9}, "expected at most 2000000"),
        ({"kind": "swamp"}, "no kind 'swamp'"),
        ({"kind": "grid", "seed": 10**18}, "seed: 1000000000000000000"),
        ({"kind": "grid", "columns": 2.5}, "columns: 2.5"),
        ({"kind": "grid", "columns": 0}, "columns: 0, expected a whole number from 1"),
    ],
)
def test_what_does_not_fit_is_refused(wanted, message):
    with pytest.raises(ColonysimError, match=message):
        invent(**wanted)


def calls(rng):
    """A random call of `colonysim new`, most often for a small world, as its options."""
    kind = rng.choice(("grid", "rooms", "platforms", "geometric"))
    walled, few = kind in ("rooms", "platforms"), (1, 1, 2, 2, 3, 3, 4, 5, 6, 8, 12)
    options = {"columns": rng.choice(few), "rows": rng.choice(few), "agents": rng.choice((1, 1, 2, 3, 4, 7, 20, 60))}
    options["seed"] = rng.choice((0, 1, rng.randrange(10**6), 10**18 - 1))
    for name, chance, values in (
        ("size", 0.6 if walled else 0.05, (1, 2, 3, 4, 5, 5, 6, 7, 9)),
        ("holes", 0.5 if kind in ("grid", "rooms") else 0.08, (1, 1, 2, 3, 6)),
        ("spare", 0.35, (1, 2, 5, 9)),
        ("depth", 0.3, (1, 2, 3, 4)),
        (rng.choice(("columns", "rows", "size", "holes", "spare", "depth", "agents", "seed")), 0.1,
         (0, -1, 10**4, 10**9, 10**18)),
    ):  # fmt: skip
        if rng.random() < chance:
            options[name] = rng.choice(values)
    words = [word for name, value in options.items() for word in (f"--{name}", str(value))]
    return [kind, *words, *(["--crowded"] if rng.random() < 0.3 else [])]


def check_a_call(number, folder):
    """One call: refused with one message, or the file is valid and can be solved; whether it was accepted."""
    words, file = calls(random.Random(number)), folder / f"{number}.yaml"
    made = CliRunner().invoke(app, ["new", *words, "-o", str(file)])
    shown = f"{' '.join(words)}: {made.output}"
    if made.exit_code:
        assert made.exit_code == 2 and not made.stdout and made.stderr.count("Error") == 1, shown
        assert made.stderr.startswith("Error: ") == (made.stderr.count("\n") == 1), shown
        assert not list(folder.iterdir()), shown
        return False
    checked = CliRunner().invoke(app, ["validate", str(file)])
    assert checked.exit_code == 0 and ": valid: " in checked.stdout, f"{shown} {checked.output}"
    scenario = load_scenario(file)
    assert len(scenario.topology) > 300 or solve(scenario), shown
    file.unlink()
    return True


def test_a_random_call_is_refused_or_writes_a_world_that_is_valid_and_can_be_solved(tmp_path):
    accepted = sum(check_a_call(number, tmp_path) for number in range(20))
    assert 3 < accepted < 17


@pytest.mark.slow
@pytest.mark.parametrize("start", range(0, 3000, 300))
def test_thousands_of_random_calls(start, tmp_path):
    assert 60 < sum(check_a_call(number, tmp_path) for number in range(start, start + 300)) < 270


def check_a_trial(number, folder):
    """Whether a call made a small world; then a colony has to solve it within three runs."""
    file = folder / f"{number}.yaml"
    if CliRunner().invoke(app, ["new", *calls(random.Random(number)), "-o", str(file)]).exit_code:
        return False
    scenario = load_scenario(file)
    if len(scenario.topology) > 150 or len(scenario.agents) > 30:
        return False
    runs = (colonysim.run(scenario, episodes=15, seed=seed, trace=False) for seed in range(3))
    assert any(episode.success == 1.0 for run in runs for episode in run.episodes), file.read_text()
    return True


def test_a_colony_solves_random_new_worlds(tmp_path):
    assert sum(check_a_trial(number, tmp_path) for number in range(3000, 3012)) >= 2


@pytest.mark.slow
def test_a_colony_solves_many_random_new_worlds(tmp_path):
    assert sum(check_a_trial(number, tmp_path) for number in range(3000, 3400)) >= 50


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("columns", "rows"), [(1, 3), (3, 1), (1, 2), (2, 1)])
def test_platforms_in_a_line_have_each_box_between_its_door_and_the_platform_that_is_reached_first(columns, rows, seed):
    scenario = colonysim.scenario_from_document(invent("platforms", columns=columns, rows=rows, size=5, seed=seed))
    for hole, box in zip(scenario.holes, scenario.boxes, strict=True):
        assert box.node in scenario.topology.neighbours[hole.node]
    assert solve(scenario)


def test_a_file_that_is_there_is_not_overwritten(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("mine")
    made = CliRunner().invoke(app, ["new", "grid", "-o", str(file)])
    assert made.exit_code == 2 and "exists already" in made.stderr and file.read_text() == "mine"
