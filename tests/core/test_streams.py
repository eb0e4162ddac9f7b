"""Random streams hang on the seed and their own name, on nothing else."""

from __future__ import annotations

import random

from small_worlds import Script, place, play

from colonysim import load_scenario
from colonysim.draws import Draws
from colonysim.randomness import Streams
from colonysim.scenario.scenario import Timing
from colonysim.world.intents import Wait


def test_a_stream_is_its_seed_and_its_name():
    streams = Streams(1)
    first = [streams.generator(name).random() for name in ("agent/0", "agent/1", "backend")]
    again = [Streams(1).generator(name).random() for name in ("backend", "agent/1", "agent/0")]
    assert first == again[::-1]
    assert len({*first, Streams(2).generator("agent/0").random()}) == 4
    assert streams.generator("agent/0").random() == first[0], "a generator is fresh each time"
    assert streams.within("episode/1").generator("a").random() != streams.within("episode/2").generator("a").random()
    assert streams.within("a").within("b").derive("c") == Streams(1, "a/b/").derive("c")


def test_the_numbers_are_the_same_on_every_machine():
    assert Streams(1).derive("agent/3") == KNOWN_SEED
    assert Streams(1).within("episode/2").generator("agent/3").random() == KNOWN_NUMBER


def test_draws_are_splitmix64_as_published_and_each_has_its_own():
    draws = Draws(0, 3)
    assert [draws.draw(0) for _ in SPLITMIX64_FROM_0] == [(z >> 11) / 2**53 for z in SPLITMIX64_FROM_0]
    others = [[draws.draw(i) for _ in range(1000)] for i in (1, 2)]
    assert len({*others[0], *others[1]}) == 2000 and all(0.0 <= x < 1.0 for x in others[0])
    assert all(abs(sum(numbers) / 1000 - 0.5) < 0.04 for numbers in others)
    alone = Draws(0, 2)
    assert [alone.draw(1) for _ in range(1000)] == others[0], "one more changes no other"


SPLITMIX64_FROM_0 = (0xE220A8397B1DCDAF, 0x6E789E6AA1B965F4, 0x06C45D188009454F)
KNOWN_SEED = 12661331789940211428
KNOWN_NUMBER = 0.9270487606509996


def two_islands(agents: list[int]):
    points = [(float(x), float(y)) for y in range(3) for x in range(3)]
    points += [(x + 100.0, y) for x, y in points]
    edges = [(i, j) for i in range(18) for j in range(i) if (points[i][0] - points[j][0]) ** 2
             + (points[i][1] - points[j][1]) ** 2 < 1.1]  # fmt: skip
    points.append((50.0, 50.0))
    return place(points, edges, goal=18, agents=agents, max_steps=60, timing=Timing(jitter=0.3))


def of_agents(events, agents):
    return [e[:11] + e[12:] for e in events if e.agent in agents]


def test_one_agent_more_changes_nothing_far_away():
    """Choices and durations alike: the third agent walks on an island of its own."""
    for policy in ("random", "colony", "paper"):
        few, _ = play(two_islands([0, 8]), policy=policy, episodes=2, seed=3)
        more, _ = play(two_islands([0, 8, 12]), policy=policy, episodes=2, seed=3)
        assert len([e for e in more if e.agent == 2]) > 50
        assert of_agents(few, {0, 1}) == of_agents(more, {0, 1}), policy


def test_agents_do_not_share_their_luck():
    events, _ = play(two_islands([0, 12]), policy="random", episodes=1, seed=3)
    first = {e.agent: e.time for e in reversed(events) if e.kind == "end"}
    assert first[0] != first[1]
    assert all(0.7 <= e.time - e.began <= 1.3 for e in events if e.kind == "end")


def test_episodes_draw_from_streams_of_their_own(backend):
    """Three episodes begin with the same two as two episodes do; each differs from the others."""
    scenario = load_scenario("easy", None, {"max_steps": 6})
    _, two = play(scenario, policy="random", backend=backend, episodes=2, seed=1)
    _, three = play(scenario, policy="random", backend=backend, episodes=3, seed=1)
    assert three.tables["events"][: len(two.tables["events"])] == two.tables["events"]
    rows = [[e[1:] for e in three.tables["events"] if e.episode == n] for n in (1, 2, 3)]
    assert rows[0] != rows[1] != rows[2]


def test_nothing_draws_from_or_reseeds_the_global_generator(backend):
    random.seed(5)
    expected = random.random()
    random.seed(5)
    play(load_scenario("sanity"), backend=backend, episodes=1)
    assert random.random() == expected


def test_seeds_differ(backend):
    scenario = load_scenario("easy", None, {"max_steps": 6})
    first, other, again = (play(scenario, backend=backend, episodes=1, seed=seed)[0] for seed in (1, 2, 1))
    assert first != other
    assert first == again


def test_looking_changes_nothing(backend):
    """A run without a sink, without decisions, and one whose policy only watches, are the same run."""
    from colonysim import simulate

    scenario = load_scenario("medium", None, {"max_steps": 6})
    events = play(scenario, backend=backend, episodes=1, seed=2)[0]
    assert list(simulate(scenario, backend=backend, episodes=1, seed=2)) == events
    assert play(scenario, backend=backend, episodes=1, seed=2, decisions=False)[0] == events
    idle = Script(lambda agent, view, n: Wait())
    assert [e.kind for e in play(scenario, policy=idle, episodes=1)[0][-1:]] == ["episode"]
