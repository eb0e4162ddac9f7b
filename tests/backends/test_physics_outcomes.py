"""Whatever goes wrong with bodies is an outcome with a reason, never an exception and never a hang."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import pytest
from backends.places import FORK, LANE, place, started

from colonysim.backends.physics import Physics
from colonysim.backends.protocol import Finished
from colonysim.errors import ColonysimError
from colonysim.physics import Scene
from colonysim.physics.shapes import quaternion
from colonysim.randomness import Streams
from colonysim.simulation import simulate
from colonysim.world.intents import BoxPlace, Intent, Outcome, Push, Travel, Wait
from colonysim.world.state import World

pytestmark = pytest.mark.usefixtures("engine")

LONGEST = 200.0
"""No action takes longer than this, simulated seconds."""

Mischief = Callable[[Scene], None]


def act(
    backend: Physics, world: World, agent: int, intent: Intent, mischief: Mischief | None = None, after: float = 1.0
) -> Outcome:
    """Carries out one intent and applies its outcome; something may happen to the bodies on the way."""
    assert world.reserve(agent, backend.footprint(agent, intent))
    world.claim(agent, intent.box if isinstance(intent, Push) else -1)
    done = backend.start(agent, intent, 0.0)
    if done is not None:
        world.apply(agent, intent, done.outcome)
        return done.outcome
    for tick in range(1, int(LONGEST * 60)):
        if mischief is not None and tick == int(after * 60):
            mischief(backend._open())
        for who, outcome in backend.advance(tick / 60):
            assert who == agent
            world.apply(agent, intent, outcome)
            return outcome
    raise AssertionError("no outcome")


def flip(scene: Scene, robot: int) -> None:
    pose = scene.robot(robot)
    body = scene._traction(robot).body
    scene._engine.place(body, (pose.x, pose.y, pose.z + 0.4), (1.0, 0.0, 0.0, 0.0))


def no_number(scene: Scene) -> None:
    scene.place_robot(0, math.nan, 0.0, 0.0, 0.0)


# -- robots that cannot go on ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("mischief", "reason"),
    [
        (no_number, "nan"),
        (lambda scene: flip(scene, 0), "flipped"),
        (lambda scene: scene.place_robot(0, 2 * 1.92, 0.0, -0.25, 0.0), "in_pit"),
        (lambda scene: scene.place_robot(0, 60.0, 0.0, -5.0, 0.0), "fallen"),
    ],
    ids=["nan", "flipped", "in_pit", "fallen"],
)
@pytest.mark.parametrize("push", [False, True], ids=["travel", "push"])
def test_a_robot_that_cannot_go_on_is_lost(mischief: Mischief, reason: str, push: bool) -> None:
    # The pit of LANE is at 2 * 1.2 graph units of 1.6 m; two agents, so that one is left.
    scenario = place(LANE, agents=[0, 4], goal=3)
    backend, world = started(scenario)
    try:
        if push:
            assert act(backend, world, 0, Push(0, 1, 0)).status == "arrived"
            outcome = act(backend, world, 0, Push(0, 2, 0), mischief)
        else:
            world.apply(0, Travel(0), Outcome("arrived", 0))
            outcome = act(backend, world, 0, Push(0, 1, 0), mischief, after=0.4)
        assert (outcome.lost, outcome.reason, outcome.status) == (True, reason, "failed")
        # The others go on.
        assert act(backend, world, 1, Travel(3)).status == "arrived"
    finally:
        backend.close()


def test_a_lost_robot_does_not_act_again() -> None:
    backend, world = started(place(LANE, agents=[0, 4], goal=3))
    try:
        outcome = act(backend, world, 0, Push(0, 1, 0), no_number, after=0.3)
        assert outcome.lost
        done = backend.start(0, Travel(1), 10.0)
        if done is None:
            finished = [f for tick in range(600) for f in backend.advance(10 + tick / 60)]
            assert [f.agent for f in finished] == [0]
            assert finished[0].outcome.lost
        else:
            assert done.outcome.status != "arrived"
    finally:
        backend.close()


# -- boxes that are not where they belong ------------------------------------------------------------------------------


def test_a_box_knocked_off_its_way_is_stray_and_another_robot_recovers_it() -> None:
    scenario = place(FORK, nodes=[[0, 0, 0], [1, 1.4, 0], [2, 2.8, 0], [3, 1.4, 1.4], [4, 1.4, -1.4], [5, 0, 1.4]])
    backend, world = started(scenario)
    try:
        assert act(backend, world, 0, Push(0, 1, -1)).status == "arrived"
        # Aside and further off than a quarter of an edge, while nobody holds it; the robot gives up and goes away.
        backend._open().place_box(0, 1.4 * 1.6 + 0.1, 0.75, 0.0, 0.1)
        outcome = act(backend, world, 0, Travel(0))
        assert outcome.status == "arrived"
        assert outcome.boxes == (BoxPlace(0, 1, stray=True),)
        assert world.box_stray == [True]
        assert act(backend, world, 0, Travel(5) if world.occupant[5] < 0 else Wait()).status in ("arrived", "blocked")
        # Agent 1 comes from 5 over 3, takes hold and pushes the box to a node again.
        assert act(backend, world, 1, Travel(3)).status == "arrived"
        assert act(backend, world, 1, Push(0, 1, -1)).status == "arrived"
        recovered = act(backend, world, 1, Push(0, 2, -1))
        assert recovered.status == "arrived", recovered
        assert recovered.boxes == (BoxPlace(0, 2, stray=False),)
        assert world.box_stray == [False]
    finally:
        backend.close()


def test_a_push_that_fails_says_where_the_box_is() -> None:
    backend, world = started(place(LANE))
    try:
        act(backend, world, 0, Push(0, 1, 0))

        def away(scene: Scene) -> None:
            scene.place_box(0, 1.2 * 1.6, 1.6, 0.0, 0.0)  # too near to the border to get behind it

        outcome = act(backend, world, 0, Push(0, 2, 0), away, after=2.0)
        assert outcome.status == "failed"
        assert outcome.reason
        assert not outcome.lost
        assert outcome.boxes == (BoxPlace(0, 1, stray=True),)
        assert outcome.node == 0 or outcome.node == 1
    finally:
        backend.close()


@pytest.mark.parametrize("push", ["scripted", "staged"])
def test_a_wedged_box_ends_the_push_with_a_reason(push: str) -> None:
    backend, world = started(place(LANE), push)
    try:
        act(backend, world, 0, Push(0, 1, 0))

        def wedge(scene: Scene) -> None:
            # Turned by an eighth, on its side, leaning on the pit's edges.
            c, s = math.cos(math.pi / 4), math.sin(math.pi / 4)
            x, y, z, w = quaternion(math.pi / 4)
            turned = (c * x + s * w, c * y + s * z, c * z - s * y, c * w - s * x)
            scene._engine.place(scene._boxes[0], (2.4 * 1.6, 0.0, 0.3), turned)

        outcome = act(backend, world, 0, Push(0, 2, 0), wedge, after=2.0)
        assert outcome.status == "failed"
        assert outcome.reason
        assert not outcome.lost
        assert all(placed.stray for placed in outcome.boxes)
    finally:
        backend.close()


def test_a_box_without_a_pose_is_stray_and_nothing_hangs() -> None:
    backend, world = started(place(LANE))
    try:
        act(backend, world, 0, Push(0, 1, 0))
        outcome = act(backend, world, 0, Push(0, 2, 0), lambda scene: scene.place_box(0, math.nan, 0, 0, 0), after=2.0)
        assert outcome.status == "failed"
        assert outcome.reason
        assert outcome.boxes == (BoxPlace(0, 1, stray=True),)
    finally:
        backend.close()


# -- what the protocol promises ----------------------------------------------------------------------------------------


def test_a_push_into_a_pit_leaves_the_robot_behind_and_opens_the_way() -> None:
    backend, world = started(place(LANE))
    try:
        assert act(backend, world, 0, Push(0, 1, 0)).status == "arrived"
        outcome = act(backend, world, 0, Push(0, 2, 0))
        assert (outcome.status, outcome.boxes) == ("arrived", (BoxPlace(0, 2),))
        assert outcome.node == 1
        for node in (2, 3, 4):
            assert act(backend, world, 0, Travel(node)).node == node
        backend.leave(0)
        assert not backend._open().has_robot(0)
        assert list(backend.advance(0.0)) == []
    finally:
        backend.close()


@pytest.mark.parametrize(
    "intent", [Travel(2), Travel(99), Travel(-1), Push(0, 2, 0), Push(0, 3, 0), Push(0, 0, 0), Wait()]
)
def test_what_cannot_be_done_is_refused_at_once(intent: Intent) -> None:
    backend, world = started(place(LANE))
    try:
        done = backend.start(0, intent, 0.0)
        assert done is not None
        assert (done.seconds, done.outcome.status, done.outcome.node) == (0.0, "blocked", 0)
        assert done.outcome.reason
        # A node with a box is no way for somebody who stands on the ground.
        done = backend.start(0, Travel(1), 0.0)
        assert done is not None
        assert done.outcome.status == "blocked"
        assert list(world.agent_node) == [0]
    finally:
        backend.close()


def test_a_cancelled_action_stops_and_never_reports() -> None:
    backend, world = started(place(FORK, boxes=[], agents=[0, 5]))
    try:
        assert backend.start(0, Travel(1), 0.0) is None
        for tick in range(60):
            assert not backend.advance(tick / 60)
        before = backend._open().robot(0)
        backend.cancel(0)
        backend.cancel(0)
        for tick in range(120):
            assert not backend.advance(1 + tick / 60)
        after = backend._open().robot(0)
        assert math.dist(before[:2], after[:2]) < 0.3
        assert act(backend, world, 0, Travel(1)).status == "arrived"
    finally:
        backend.close()


def test_closing_twice_is_allowed_and_a_closed_backend_says_so() -> None:
    backend, _ = started(place(LANE))
    assert backend.start(0, Push(0, 1, 0), 0.0) is None
    backend.close()
    backend.close()
    with pytest.raises(ColonysimError, match="closed"):
        backend.advance(0.0)


def test_poses_of_movers_come_ten_times_a_second() -> None:
    backend, world = started(place(FORK, boxes=[]))
    try:
        first = list(backend.rows())
        assert sorted((row.row[1], row.row[2]) for row in first) == [("agent", 0), ("agent", 1)]
        assert act(backend, world, 0, Travel(1)).status == "arrived"
        rows = [row.row for row in backend.rows() if row.table == "poses"]
        times = [row[0] for row in rows[:-1]]
        assert {row[2] for row in rows} == {0}
        assert all(b - a == pytest.approx(0.1) for a, b in itertools.pairwise(times))
    finally:
        backend.close()


def test_with_staged_every_control_between_handover_and_back_off_is_the_networks() -> None:
    backend, world = started(place(LANE), "staged")
    try:
        act(backend, world, 0, Push(0, 1, 0))
        list(backend.rows())
        outcome = act(backend, world, 0, Push(0, 2, 0))
        assert outcome.status == "arrived", outcome
        controls = [row.row for row in backend.rows() if row.table == "controls"]
        steps = [(str(row[2]), str(row[3]), int(str(row[4]))) for row in controls]
        assert sum(ticks for who, _, ticks in steps if who == "network") > 60
        # The script drives up to the box, and away from it; what moves the box is the network's choice.
        assert {name for who, name, _ in steps if who == "script"} <= {"travel", "rotate", "back", "wait"}
        for (who, _, _), (next_who, name, _) in itertools.pairwise(steps):
            if who == "network" and next_who == "script":
                assert name == "back"
    finally:
        backend.close()


def test_no_such_executor_and_no_such_model() -> None:
    with pytest.raises(ColonysimError, match="staged"):
        Physics(push="stage")
    with pytest.raises(ColonysimError):
        Physics(model="/no/such/card.json")


def test_reset_starts_anew() -> None:
    backend, world = started(place(LANE))
    try:
        before = [backend._open().robot(0), backend._open().box(0)]
        act(backend, world, 0, Push(0, 1, 0))
        act(backend, world, 0, Push(0, 2, 0))
        world.reset()
        backend.reset(world, Streams(0))
        assert [backend._open().robot(0), backend._open().box(0)] == before
    finally:
        backend.close()


def test_a_robot_whose_way_stays_shut_gives_up() -> None:
    backend, _ = started(place(FORK, boxes=[]))
    try:
        scene = backend._open()
        x, y = backend._layout.places[1]
        scene.place_robot(1, x, y, 0.0, 0.0)
        assert backend.start(0, Travel(1), 0.0) is None
        finished: list[Finished] = []
        for tick in range(60 * 60):
            finished += backend.advance(tick / 60)
            if finished:
                break
        assert [(agent, outcome.status, outcome.node) for agent, outcome in finished] == [(0, "blocked", 0)]
        assert finished[0].outcome.reason
    finally:
        backend.close()


def test_a_standstill_ends_the_episode() -> None:
    class Still(Physics):
        """Its robots never start: their time does not pass."""

        def advance(self, now):  # type: ignore[no-untyped-def]
            return ()

    scenario, body = place({**LANE, "holes": [], "boxes": [], "stall_seconds": 20}), Still(push="scripted")
    events = list(simulate(scenario, backend=body, episodes=1, seed=1))
    assert events[-1].status == "deadlock"
    # What is under way is no stall; but nobody waits longer than for a hundred edges.
    assert events[-1].time == pytest.approx(100.0 * body.edge_seconds, rel=0.01)
