"""Nobody is favoured for a number: where all agents stand alike, who comes first is drawn, not counted.

For every symmetric world and both modes, agents are ranked in each run by when they arrive (or take the box) and by
how often they had to wait. Over the seeds, Friedman's test asks whether any number differs from the others, and Page's
whether ranks go up or down with the number. All tests together may fail by chance once in a thousand (Bonferroni).
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace
from itertools import product

import pytest
from small_worlds import Script, line, place, play

from colonysim import simulate
from colonysim.backends.mock import Mock
from colonysim.randomness import Streams
from colonysim.scenario.scenario import Timing
from colonysim.world.intents import Travel, Wait

ERROR = 1e-3
FOUR = [(5.0, 0.0), (0.0, 5.0), (-5.0, 0.0), (0.0, -5.0)]
EIGHT = [(sx * x, sy * y) for x, y in ((3.0, 4.0), (4.0, 3.0)) for sx in (1, -1) for sy in (1, -1)]
AROUND = {4: FOUR, 8: EIGHT, 12: FOUR + EIGHT}
"""All exactly as far from the middle, so that nothing but a tie can decide."""


def star(rays: int, length: int, **fields):
    """Ways of some nodes to one goal in the middle, an agent at the end of each."""
    points = [(0.0, 0.0), *((x * k, y * k) for x, y in AROUND[rays] for k in range(1, length + 1))]
    edges = [(1 + ray * length + k, 0 if k == 0 else ray * length + k) for ray in range(rays) for k in range(length)]
    return place(points, edges, goal=0, agents=[(ray + 1) * length for ray in range(rays)], max_steps=40, **fields)


def neck(rays: int, **fields):
    """A hub, and the goal behind it: one place for all to pass through."""
    points = [(0.0, 0.0), (0.0, 0.0), *AROUND[rays]]
    edges = [(0, 1), *((1, 2 + ray) for ray in range(rays))]
    timing = fields.pop("timing", Timing(jitter=0.0, travel_fixed=1.0))
    return place(points, edges, goal=0, agents=range(2, 2 + rays), max_steps=40, timing=timing, **fields)


def ring(rays: int, **fields):
    """A ring round the goal: who does not get in may go round."""
    points = [(0.0, 0.0), *sorted(AROUND[rays], key=lambda at: math.atan2(at[1], at[0]))]
    edges = [(0, ray) for ray in range(1, rays + 1)] + [(ray, ray % rays + 1) for ray in range(1, rays + 1)]
    return place(points, edges, goal=0, agents=range(1, rays + 1), max_steps=40, **fields)


def grid(size: int, starts: int, **fields):
    """A square with the goal in its middle; agents in the corners, or twice as many in a knight's moves."""
    half = size // 2
    points = [(float(x), float(y)) for y in range(-half, half + 1) for x in range(-half, half + 1)]
    edges = [(i, j) for i in range(len(points)) for j in range(i) if math.dist(points[i], points[j]) == 1.0]
    corners = [(sx * half, sy * half) for sx in (1, -1) for sy in (1, -1)]
    knights = [(sx * a, sy * b) for a, b in ((half, half - 1), (half - 1, half)) for sx in (1, -1) for sy in (1, -1)]
    agents = [points.index(at) for at in (corners if starts == 4 else knights)]
    return place(points, edges, goal=len(points) // 2, agents=agents, max_steps=60, **fields)


def box(rays: int, **fields):
    """A box that all stand around, and a hole for it behind every second node."""
    points = [(0.0, 0.0), *FOUR, *((x, y) for x, y in EIGHT if rays == 8), (0.0, 0.0)]
    goal = len(points) - 1
    beyond = [(2 * x, 2 * y) for x, y in points[1:goal]]
    edges = [(0, ray) for ray in range(1, goal)] + [(ray, goal + ray) for ray in range(1, goal)]
    edges += [(goal + ray, goal) for ray in range(1, goal)]
    agents = range(1, 5) if rays == 4 else range(5, 13)
    holes = {goal + ray: (-1.0, 0.0) for ray in range(1, goal)}
    return place(
        [*points, *beyond], edges, goal=goal, agents=agents, boxes=[(0, 1.0)], holes=holes, max_steps=30,
        detection_radius=20.0, **fields,
    )  # fmt: skip


VARIED = {"timing": Timing(jitter=0.1)}
WORLDS = {
    **{f"star {rays}x{length}": star(rays, length) for rays, length in product((4, 8, 12), (1, 3))},
    "star 8x2 jitter": star(8, 2, **VARIED),
    **{f"neck {rays}": neck(rays) for rays in (4, 8, 12)},
    "neck 8 jitter": neck(8, timing=Timing(jitter=0.1, travel_fixed=1.0)),
    **{f"ring {rays}": ring(rays) for rays in (4, 8)},
    "ring 8 jitter": ring(8, **VARIED),
    **{f"grid {size}, {starts} agents": grid(size, starts) for size, starts in product((5, 9), (4, 8))},
    **{f"box {rays}": box(rays) for rays in (4, 8)},
}
FEW = ("star 8x1", "neck 8", "ring 4", "grid 5, 8 agents", "box 4")


def ranks(values: list[float]) -> list[float]:
    """1 for the least; equal ones share the mean of their ranks."""
    return [sum((v < value) + 0.5 * (v == value) for v in values) + 0.5 for value in values]


def places(scenario, mode: str, seed: int) -> tuple[list[float], list[float]]:
    """The ranks of all agents in one run: of arrival, or of the first box; and of waits."""
    count, first, waits = len(scenario.agents), {}, Counter()
    for order, event in enumerate(simulate(scenario, policy="colony", mode=mode, episodes=1, seed=seed)):
        if event.kind == "goal" or (event.kind == "end" and event.action == "take"):
            first.setdefault(event.agent, order)
        elif event.kind == "wait":
            waits[event.agent] += 1
    return ranks([first.get(a, math.inf) for a in range(count)]), ranks([waits[a] for a in range(count)])


def chi_square_beyond(x: float, degrees: int) -> float:
    """The chance that a chi-square of so many degrees of freedom is greater."""
    half = x / 2
    if degrees % 2 == 0:
        return sum(math.exp(-half + i * math.log(half) - math.lgamma(i + 1)) if half else i == 0
                   for i in range(degrees // 2))  # fmt: skip
    rest = range(1, (degrees + 1) // 2)
    return math.erfc(math.sqrt(half)) + sum(
        math.exp(-half + (i - 0.5) * math.log(half) - math.lgamma(i + 0.5)) for i in rest if half
    )


def chances(rows: list[list[float]]) -> tuple[float, float]:
    """Of ranks as uneven, and as much in order of number, as these by chance alone: Friedman's and Page's tests."""
    count, mean = len(rows[0]), (len(rows[0]) + 1) / 2
    spread = sum((rank - mean) ** 2 for row in rows for rank in row)
    if spread == 0.0:
        return 1.0, 1.0
    sums = [sum(column) - len(rows) * mean for column in zip(*rows, strict=True)]
    uneven = (count - 1) * sum(total**2 for total in sums) / spread
    trend = sum((number + 1 - mean) * total for number, total in enumerate(sums))
    variance = spread / (count - 1) * sum((number + 1 - mean) ** 2 for number in range(count))
    return chi_square_beyond(uneven, count - 1), math.erfc(abs(trend) / math.sqrt(2 * variance))


def check(names, seeds: int) -> list[tuple[str, str, str, str, float, float]]:
    """The chance of what is found, for every world, mode, listing and measure; none may be too small."""
    found = []
    for name, mode, listing in product(names, ("asynchronous", "synchronous"), ("", "reversed")):
        scenario = WORLDS[name]
        if listing:
            scenario = replace(scenario, agents=tuple(reversed(scenario.agents)))
        runs = [places(scenario, mode, seed) for seed in range(seeds)]
        for measure, rows in zip(("first", "waits"), zip(*runs, strict=True), strict=True):
            found.append((name, mode, listing, measure, *chances(list(rows))))
    limit = ERROR / (2 * len(found))
    assert not [row for row in found if min(row[4:]) < limit]
    return found


def test_in_a_symmetric_place_no_number_is_a_rank():
    check(FEW, 25)


@pytest.mark.slow
def test_in_20_symmetric_places_no_number_is_a_rank():
    assert len(WORLDS) == 20
    found = check(WORLDS, 200)
    for name, mode, listing, measure, uneven, trend in found:
        print(f"{name:20} {mode:13} {listing:9} {measure:6} Friedman p {uneven:.4f}  Page p {trend:.4f}")
    # What is left to chance is spread evenly: a small favour everywhere would gather at the low end.
    for column in (4, 5):
        low = sum(row[column] < 0.05 for row in found) / len(found)
        assert low < 0.1, low


def test_the_test_sees_a_favour():
    fair = [ranks([(7 * a + 3 * seed) % 8 for a in range(8)]) for seed in range(40)]
    assert min(chances(fair)) > 0.1
    favoured = [[1.0, *(rank + 1 for rank in ranks([(3 * a + seed) % 7 for a in range(7)]))] for seed in range(40)]
    assert max(chances(favoured)) < 1e-4
    assert chi_square_beyond(11.07, 5) == pytest.approx(0.05, abs=1e-4)
    assert chi_square_beyond(9.488, 4) == pytest.approx(0.05, abs=1e-4)


def first_of(runs) -> Counter:
    return Counter(next(e.agent for e in events if e.kind == "end") for events, _ in runs)


@pytest.mark.parametrize("tick", [None, 0.25])
def test_what_ends_at_the_same_time_ends_in_an_order_that_is_drawn(tick):
    """On a backend with a clock too, whatever the order in which it tells of what has ended."""
    points = [(float(i), 0.0) for i in range(8)]
    scenario = place(points, [(0, 1), (2, 3), (4, 5), (6, 7)], goal=7, agents=[0, 2, 4], max_steps=1)
    policy = Script(lambda agent, view, n: Travel(2 * agent + 1) if n == 0 else Wait())
    runs = [play(scenario, policy=policy, backend=Mock(tick=tick), episodes=1, seed=seed) for seed in range(60)]
    assert min(first_of(runs)[agent] for agent in range(3)) > 8


def test_who_is_called_by_the_same_change_chooses_in_an_order_that_is_drawn_each_time():
    """Two wait for a place that a third leaves again and again; the order is not that of one draw for all times."""
    scenario = place(
        [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (9.0, 9.0)], [(0, 1), (0, 2), (0, 3)], goal=4,
        agents=[1, 2, 3], max_steps=12,
    )  # fmt: skip
    heard = []

    def act(agent, view, n):
        if agent == 0:
            return Travel(0 if view.node == 1 else 1)
        heard[-1].append(agent)
        return Wait((0,))

    orders = set()
    for seed in range(20):
        heard.append([])
        play(scenario, policy=Script(act), episodes=1, seed=seed)
        orders.add(tuple(heard[-1][2:12]))
    assert len(orders) > 10 and {1, 2} == {who for order in orders for who in order}
    assert any(order[::2].count(1) not in (0, 5) for order in orders)


def test_who_waited_for_a_place_chooses_before_who_has_just_left_it():
    """Agent 0 leaves the hub for a dead end and wants back at once; agent 1, who waited for it, is always first."""
    points = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (9.0, 9.0)]
    scenario = place(points, [(0, 1), (0, 2)], goal=3, agents=[0, 1], max_steps=4)

    def act(agent, view, n):
        if agent == 0:
            return Travel(2 if view.node == 0 else 0)
        return Travel(0) if view.node == 1 and view.free(0) else Wait((0,))

    for seed in range(40):
        events, _ = play(scenario, policy=Script(act), episodes=1, seed=seed)
        ends = [(event.agent, event.target) for event in events if event.kind == "end"]
        assert ends[:2] == [(0, 2), (1, 0)]


def test_lots_are_of_a_stream_of_their_own(monkeypatch):
    """Other lots change who comes first where much happens at the same time, and nothing where nothing does."""
    alone, together = line(6, goal=5, agents=[0], timing=Timing(jitter=0.1)), WORLDS["ring 8"]
    before = [play(scenario, policy="random", episodes=2, seed=5)[0] for scenario in (alone, together)]
    draws = Streams.draws
    monkeypatch.setattr(Streams, "draws", lambda self, name, n: draws(self, {"ties": "others"}.get(name, name), n))
    after = [play(scenario, policy="random", episodes=2, seed=5)[0] for scenario in (alone, together)]
    assert before[0] == after[0] and before[1] != after[1]
