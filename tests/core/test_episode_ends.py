"""How an episode ends, and what its steps and its success are; on every backend, but for exact times."""

from __future__ import annotations

from itertools import islice

import pytest
from small_worlds import Script, Scripted, line, place, play

from colonysim import load_scenario, simulate
from colonysim.backends.mock import Mock
from colonysim.backends.protocol import Done, Finished
from colonysim.errors import ColonysimError, PluginError
from colonysim.scenario.scenario import Timing
from colonysim.world.intents import Outcome, Push, Travel, Wait

ON = Script(lambda agent, view, n: Travel(view.node + 1))


def result(scenario, **options):
    options.setdefault("episodes", 1)
    events, rows = play(scenario, **options)
    last = events[-1]
    assert last.kind == "episode" and last.status == rows.episodes[-1].ended and last.step == rows.episodes[-1].steps
    return events, rows.episodes[-1]


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_goal_counts_the_largest_number_of_steps(mode, backend):
    scenario = line(6, goal=5, agents=[1, 4], max_steps=20)
    events, end = result(scenario, policy=ON, mode=mode, backend=backend)
    assert (end.ended, end.steps, end.success) == ("goal", 4, 1.0)
    if backend == "nodeworld":
        assert end.sim_seconds == pytest.approx(4.0)
    assert [(e.agent, e.node) for e in events if e.kind == "goal"] == [(1, 5), (0, 5)]


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_max_steps_when_somebody_is_left_and_spent_agents_stay_where_they_are(mode, backend):
    # Agent 0 walks to and fro and is spent on its way; agent 1, later on, walks past where it does not stand.
    points = [(0.0, 0.0), (1.0, 0.0), (0.0, 5.0), (1.0, 5.0), (2.0, 5.0), (3.0, 5.0), (4.0, 5.0), (5.0, 5.0)]
    edges = [(0, 1), (2, 3), (3, 4), (4, 5), (5, 6), (6, 7)]
    timing = Timing(jitter=0.0, travels={(0, 1): 0.1, (1, 0): 0.1})
    scenario = place(points, edges, goal=7, agents=[0, 2], max_steps=5, timing=timing)
    policy = Script(lambda agent, view, n: Travel(1 - view.node if agent == 0 else view.node + 1))
    events, end = result(scenario, policy=policy, mode=mode, backend=backend)
    assert (end.ended, end.steps, end.success) == ("max_steps", 5, 0.5)
    spent = [e for e in events if e.kind == "spent"]
    assert [(e.agent, e.node, e.step) for e in spent] == [(0, 1, 5)]
    if mode == "asynchronous" and backend == "nodeworld":
        assert spent[0].time == pytest.approx(0.5)
        assert [e.time for e in events if e.kind == "goal"] == pytest.approx([5.0]), "the others act on"


def test_a_spent_agent_bars_the_way():
    def act(agent, view, n):
        if agent == 0:  # to and fro, spent on 3
            return Travel(3 if view.node == 2 else 2)
        return Travel(view.node + 1) if view.free(view.node + 1) else Wait((view.node + 1,))

    timing = Timing(jitter=0.0, travels={(2, 3): 0.1, (3, 2): 0.1})
    events, end = result(line(6, goal=5, agents=[2, 0], max_steps=3, timing=timing), policy=Script(act))
    assert [e.node for e in events if e.kind == "spent"] == [3]
    last = [e for e in events if e.agent == 1][-1]
    assert (last.kind, last.node, last.target) == ("wait", 2, 3)
    assert (end.ended, end.success, end.steps) == ("deadlock", 0.0, 3)


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_deadlock_when_nobody_can_be_woken(mode, backend):
    waiting = Script(lambda agent, view, n: Wait(tuple(view.neighbours)))
    _, end = result(line(4, goal=3, agents=[0, 1], max_steps=7), policy=waiting, mode=mode, backend=backend)
    assert (end.ended, end.steps, end.success, end.sim_seconds) == ("deadlock", 7, 0.0, 0.0)


def test_deadlock_when_nothing_has_come_out_for_stall_seconds():
    ticking = Script(lambda agent, view, n: Travel(1) if n == 0 else Wait((), 1.0))
    _, end = result(line(4, goal=3, agents=[0], stall_seconds=30.0), policy=ticking)
    assert end.ended == "deadlock"
    assert end.sim_seconds == pytest.approx(31.0), "counted from the last outcome, at 1"


def test_timeout_at_the_limit_of_simulated_seconds(backend):
    scenario = line(9, goal=8, agents=[0], time_limit=3.5)
    events, end = result(scenario, policy=ON, backend=backend)
    assert (end.ended, end.steps, end.success, end.sim_seconds) == ("timeout", 50, 0.0, 3.5)
    times = [e.time for e in events if e.kind == "end"]
    assert times == [1.0, 2.0, 3.0] if backend == "nodeworld" else all(time <= 3.5 for time in times)


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_lost_when_nobody_is_left_who_can_act(mode):
    def answer(agent, intent, now):
        if agent == 0 and intent.node == 2:
            return Done(1.0, Outcome("failed", 1, reason="tipped", lost=True))
        return Done(1.0, Outcome("arrived", intent.node))

    body = Scripted(answer)
    events, end = result(line(6, goal=5, agents=[0]), policy=ON, backend=body, mode=mode)
    assert (end.ended, end.steps, end.success) == ("lost", 50, 0.0)
    assert [(e.node, e.agent) for e in events if e.kind == "lost"] == [(1, 0)]
    assert body.closed == 1
    # Another that arrives changes the share, not the end; the lost one's node is taken.
    events, end = result(line(6, goal=5, agents=[0, 4]), policy=ON, backend=body, mode=mode)
    assert (end.ended, end.success) == ("lost", 0.5)
    assert body.left == [1]
    _, end = result(line(6, goal=0, agents=[1]), policy=ON, backend=body, mode=mode, episodes=2)
    assert end.episode == 2 and end.ended == "lost", "the next episode sets it on its wheels again"


def test_waits_are_no_steps_in_asynchronous_mode(backend):
    policy = Script(lambda agent, view, n: Wait((), 1.0) if n < 5 else Travel(view.node + 1))
    events, end = result(line(3, goal=2, agents=[0], max_steps=4), policy=policy, backend=backend)
    assert (end.ended, end.steps) == ("goal", 2)
    assert next(e.began for e in events if e.kind == "end") == 5.0
    if backend == "nodeworld":
        assert end.sim_seconds == 7.0
    assert [e.kind for e in events].count("wait") == 5


def test_every_tick_is_a_step_in_synchronous_mode(backend):
    policy = Script(lambda agent, view, n: Wait((), 1.0) if n < 5 else Travel(view.node + 1))
    _, end = result(line(3, goal=2, agents=[0], max_steps=9), policy=policy, mode="synchronous", backend=backend)
    assert (end.ended, end.steps) == ("goal", 7)
    _, end = result(line(3, goal=2, agents=[0], max_steps=4), policy=policy, mode="synchronous", backend=backend)
    assert (end.ended, end.steps, end.success) == ("max_steps", 4, 0.0)


def test_failed_and_blocked_actions_are_steps():
    def answer(agent, intent, now):
        status = "blocked" if now < 1 else "failed" if now < 2 else "arrived"
        return Done(1.0, Outcome(status, intent.node if status == "arrived" else 0, reason=status))

    events, end = result(line(2, goal=1, agents=[0]), policy=ON, backend=Scripted(answer))
    assert (end.ended, end.steps) == ("goal", 3)
    assert [(e.status, e.step, e.now_at) for e in events if e.kind == "end"] == [
        ("blocked", 1, 0), ("failed", 2, 0), ("arrived", 3, 1),
    ]  # fmt: skip


def test_agents_act_in_their_own_time():
    points = [(float(i), 0.0) for i in range(4)] + [(float(i), 9.0) for i in range(4)] + [(99.0, 0.0)]
    edges = [(0, 1), (1, 2), (2, 3), (4, 5), (5, 6), (6, 7)]
    timing = Timing(jitter=0.0, travels={(4, 5): 0.25, (5, 6): 0.25, (6, 7): 0.25})
    scenario = place(points, edges, goal=8, agents=[0, 4], timing=timing, max_steps=3)
    events, _ = result(scenario, policy=ON)
    order = [(e.time, e.agent) for e in events if e.kind == "end"]
    assert order == [(0.25, 1), (0.5, 1), (0.75, 1), (1.0, 0), (2.0, 0), (3.0, 0)]
    events, _ = result(scenario, policy=ON, mode="synchronous")
    ends = [(e.time, e.agent) for e in events if e.kind == "end"]
    assert [time for time, _ in ends] == sorted(time for time, _ in ends), "of one tick, in an order that is drawn"
    assert sorted(ends) == [(t, a) for t in (1.0, 2.0, 3.0) for a in (0, 1)]


def test_a_waiting_agent_is_woken_by_what_it_waits_for_and_by_nothing_else():
    asked = []

    def act(agent, view, n):
        if agent == 1:
            asked.append((view.node, n))
            return Wait((2,)) if not view.free(2) or n == 0 or view.node == 2 else Travel(2)
        return Travel(view.node + 1)

    # 0 and 1 stand apart; agent 0 walks 2-3-4, agent 1 waits on 1 for node 2 to fall free.
    events, _ = result(line(6, goal=5, agents=[2, 1], max_steps=3), policy=Script(act))
    first = next(e for e in events if e.kind == "end" and e.agent == 1)
    assert (first.began, first.target) == (1.0, 2)
    assert [n for node, n in asked if node == 1] == [0, 1]


def test_whoever_waits_for_the_goal_is_woken_when_it_is_left(backend):
    policy = Script(lambda agent, view, n: Travel(2) if view.free(2) else Wait((2,)))
    events, end = result(line(3, goal=2, agents=[1, 2]), policy=policy, backend=backend)
    assert end.ended == "goal"
    if backend == "nodeworld":
        assert end.sim_seconds == 1.0
    assert [e.kind for e in events if e.agent == 0] == ["start", "wait", "end", "goal"]


def test_a_refused_reservation_waits_and_tries_again(backend):
    def act(agent, view, n):
        return Travel(1) if view.node != 1 else Travel(3)

    scenario = place([(0, 0), (1, 0), (2, 0), (1, 1)], [(0, 1), (1, 2), (1, 3)], goal=3, agents=[0, 2])
    events, end = result(scenario, policy=Script(act), backend=backend)
    assert end.ended == "goal"
    assert next((e.agent, e.target) for e in events if e.kind == "wait") == (1, 1)
    arrivals = [(e.time, e.agent) for e in events if e.kind == "end" and e.target == 1]
    assert [agent for _, agent in arrivals] == [0, 1]
    if backend == "nodeworld":
        assert arrivals == [(1.0, 0), (3.0, 1)]


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_no_two_agents_swap_places(mode, backend):
    swap = Script(lambda agent, view, n: Travel(1 - view.node))
    scenario = line(3, goal=2, agents=[0, 1], stall_seconds=20, max_steps=9)
    events, end = result(scenario, policy=swap, mode=mode, backend=backend)
    assert end.ended in ("deadlock", "max_steps") and not [e for e in events if e.kind == "end"]


class Clocked(Scripted):
    """Answers from `advance`, three ticks after the start."""

    tick = 0.25

    def __init__(self, ticks: int = 3) -> None:
        super().__init__(lambda agent, intent, now: None)
        self.due: dict[int, tuple[int, object]] = {}
        self.ticks = ticks
        self.advanced = 0
        self.times: list[float] = []

    def start(self, agent, intent, now):
        self.due[agent] = (self.ticks, intent)

    def advance(self, now):
        self.advanced += 1
        self.times.append(now)
        done = []
        for agent, (left, intent) in list(self.due.items()):
            if left <= 1:
                del self.due[agent]
                done.append(Finished(agent, Outcome("arrived", intent.node)))
            else:
                self.due[agent] = (left - 1, intent)
        return done


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_a_ticking_backend_s_clock_runs_only_while_something_is_pending(mode):
    policy = Script(lambda agent, view, n: Wait((), 10.0) if n == 1 else Travel(view.node + 1))
    body = Clocked()
    _, end = result(line(3, goal=2, agents=[0]), policy=policy, backend=body, mode=mode)
    assert end.ended == "goal" and body.advanced == 6
    if mode == "asynchronous":
        assert end.sim_seconds == pytest.approx(0.75 + 10.0 + 0.75)


def test_ticks_neither_overtake_an_agent_nor_end_late():
    """While agent 0's action lasts a thousand ticks, agent 1 looks up now and then."""
    body, looked = Clocked(ticks=1000), []
    body.tick = 1 / 60

    def act(agent, view, n):
        if agent == 0:
            return Travel(view.node + 1)
        looked.append(body.advanced)
        return Wait((), 0.37)

    events, _ = result(line(5, goal=4, agents=[0, 2], time_limit=40.0), policy=Script(act), backend=body)
    assert looked[:5] == [int(0.37 * n * 60) for n in range(5)]
    now, times = 0.0, []
    for _ in range(1000):
        now += 1 / 60
        times.append(now)
    assert body.times[:1000] == times
    assert next(e.time for e in events if e.kind == "end") == now


def test_what_is_pending_at_the_end_is_cancelled():
    body = Clocked(ticks=1000)
    _, end = result(line(3, goal=2, agents=[0], time_limit=5.0), policy=ON, backend=body)
    assert end.ended == "timeout" and body.cancelled == [0]
    assert body.advanced == 20, "no tick beyond the limit"


def test_a_node_that_a_body_kept_wakes_those_who_waited_for_it_when_it_is_let_go():
    """Agent 0 sticks out over node 1 until its next action; agent 1 waits there without a timer."""

    def answer(agent, intent, now):
        if agent == 0:
            return Done(1.0, Outcome("arrived", intent.node, keeps=(1,) if intent.node == 2 else ()))
        return Done(1.0, Outcome("arrived", intent.node))

    def act(agent, view, n):
        if agent == 0:
            return Travel(2) if n == 0 else Wait((), 5.0) if n == 1 else Travel(3) if n == 2 else Travel(4)
        return Travel(1) if view.node == 0 and view.free(1) and n > 0 else Wait((1,)) if view.node == 0 else Wait()

    points = [(0, 0), (1, 0), (2, 0), (3, 0), (4, 0)]
    scenario = place(points, [(0, 1), (1, 2), (2, 3), (3, 4)], goal=4, agents=[1, 0], max_steps=9, stall_seconds=60)
    events, _ = result(scenario, policy=Script(act), backend=Scripted(answer))
    moved = next(e for e in events if e.kind == "end" and e.agent == 1)
    assert moved.target == 1 and moved.began == pytest.approx(6.0)


def test_a_refused_push_asks_its_node_to_be_cleared():
    asked = []

    def act(agent, view, n):
        if agent == 1:
            asked.append(view.asked_to_clear)
            return Travel(3) if view.asked_to_clear and view.node == 2 else Wait((9,), 50.0)
        return Push(0, 1, -1) if n == 0 else Push(0, 2, -1) if view.node == 1 else Wait()

    points = [(0, 0), (1, 0), (2, 0), (2, 1), (9, 9), (9, 8), (9, 7), (9, 6), (9, 5), (9, 4)]
    scenario = place(points, [(0, 1), (1, 2), (2, 3)], goal=4, agents=[0, 2], boxes=[(1, 1.0)], max_steps=2)
    events, _ = result(scenario, policy=Script(act))
    assert asked[:2] == [False, True]
    pushed = next(e for e in events if e.action == "push")
    assert pushed.target == 2 and pushed.began == pytest.approx(2.0), "as soon as the node was free"


def test_two_that_ask_each_other_to_make_way_do_not_keep_each_other_awake(backend):
    policy = Script(lambda agent, view, n: Wait((1 - agent,), 5.0, 1 - agent))
    scenario = line(4, goal=3, agents=[0, 1], stall_seconds=20)
    events = list(islice(simulate(scenario, policy=policy, backend=backend, episodes=1), 100))
    assert (events[-1].kind, events[-1].status) == ("episode", "deadlock")
    assert len([e for e in events if e.kind == "wait"]) < 15


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_waiting_is_counted_in_edges_and_begins_anew_after_each_action(mode):
    waited = []

    def act(agent, view, n):
        waited.append(view.waited)
        return Travel(view.node + 1) if n in (2, 4) else Wait((), 1.0)

    result(line(3, goal=2, agents=[0]), policy=Script(act), mode=mode)
    assert waited == pytest.approx([0.0, 1.0, 2.0, 0.0, 1.0])


def test_a_mode_that_does_not_exist():
    with pytest.raises(ColonysimError, match="asynchronous"):
        next(iter(simulate(load_scenario("sanity"), mode="async")))


def test_a_backend_is_closed_when_nobody_listens_any_more():
    body = Scripted(lambda agent, intent, now: Done(1.0, Outcome("arrived", intent.node)))
    events = simulate(line(5, goal=4, agents=[0]), policy=ON, backend=body, episodes=1)
    next(events)
    events.close()
    assert body.closed == 1


def test_who_waits_for_a_place_goes_before_who_comes_from_it():
    """One agent paces between 1 and 2, another waits for 1: it is let in as soon as the node is free."""

    def act(agent, view, n):
        if agent == 0:
            return Travel(1) if view.free(1) and view.node == 0 else Wait((1,))
        return Travel(2 if view.node == 1 else 1) if view.free(1) or view.node == 1 else Wait((1,))

    scenario = line(4, goal=3, agents=[0, 1], max_steps=6)
    events, _ = result(scenario, policy=Script(act))
    entered = next(e for e in events if e.kind == "end" and e.agent == 0)
    assert entered.target == 1 and entered.began == pytest.approx(1.0)


def test_who_asks_first_for_a_place_is_served_first_and_a_request_ends_with_the_wait():
    asked = {}

    def act(agent, view, n):
        if agent == 2:  # stands on 1 until 10 s, then leaves by 3
            asked.update(world=view._world)
            return Wait((), 10.0) if n == 0 else Travel(3) if view.node == 1 else Wait((), 50.0)
        if agent == 1 and n == 0:
            return Wait((), 1.0)
        if view.node == 1:
            return Wait((), 50.0)
        return Travel(1) if view.free(1) and not view.wanted(1) else Wait((1,), None, 1)

    points = [(0, 0), (1, 0), (1, 1), (2, 0), (9, 9)]
    scenario = place(points, [(0, 1), (1, 2), (1, 3)], goal=4, agents=[0, 2, 1], max_steps=3, stall_seconds=30)
    events, _ = result(scenario, policy=Script(act))
    entered = [e.agent for e in events if e.kind == "end" and e.target == 1]
    assert entered == [0]
    assert asked["world"].clear_requests == {1: 1}, "the other one asks in its turn"


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
@pytest.mark.parametrize("policy", ["colony", "paper"])
def test_an_agent_that_is_under_way_for_long_is_no_deadlock(policy, mode):
    points = [(1000.0 * i, 0.0) for i in range(4)]
    scenario = place(points, [(0, 1), (1, 2), (2, 3)], goal=3, agents=[0, 1], detection_radius=5000.0)
    _, end = result(scenario, policy=policy, mode=mode)
    assert (end.ended, end.success) == ("goal", 1.0) and end.sim_seconds > scenario.stall_seconds


def test_who_waits_beside_a_very_long_action_looks_up_ever_more_seldom():
    """Before the stall at the pace that it asks for; while a journey of 1e8 s lasts, in all some thousand times."""
    waits = []

    def act(agent, view, n):
        if agent == 0:
            return Travel(view.node + 1)
        waits.append(n)
        return Wait((), 1.0)

    timing = Timing(jitter=0.0, travels={(0, 1): 1e8})
    scenario = line(3, goal=1, agents=[0, 2], stall_seconds=60.0, timing=timing)
    events, end = result(scenario, policy=Script(act))
    assert [e.agent for e in events if e.kind == "goal"] == [0]
    assert end.ended == "deadlock" and 60 < len(waits) < 4000


def test_an_action_that_never_ends_is_a_deadlock_after_a_hundred_times_its_edge_s_time():
    class Stuck(Scripted):
        tick = 0.5

    _, end = result(line(4, goal=3, agents=[0], stall_seconds=20.0), policy=ON, backend=Stuck(lambda *_: None))
    assert end.ended == "deadlock" and end.sim_seconds == pytest.approx(100.0, abs=1.0)


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_nobody_is_at_the_goal_behind_a_box_on_it_or_short_of_it(mode):
    """Who takes hold of a box on the goal stands beside it; who was stopped on the last edge has not got there."""
    way = [Travel(1), Travel(2), Push(0, 3, -1), Push(0, 2, -1), Travel(3)]
    scenario = line(4, goal=3, agents=[0], boxes=[(3, 0.35)], max_steps=9)
    events, end = result(scenario, policy=Script(lambda agent, view, n: way[min(n, 4)]), mode=mode)
    assert [e.action for e in events if e.kind == "end"] == ["travel", "travel", "take", "push", "travel"]
    assert (end.ended, end.steps) == ("goal", 5)
    short = [Outcome("blocked", 1, reason="timeout"), None, None]
    there_and_back = Script(lambda agent, view, n: Travel(1 - view.node))
    options = {"policy": there_and_back, "backend": Mock(short), "mode": mode}
    events, end = result(line(2, goal=1, agents=[0], max_steps=9), **options)
    assert [e.status for e in events if e.kind == "end"] == ["blocked", "arrived", "arrived"]
    assert (end.ended, end.steps) == ("goal", 3)


def test_a_policy_that_waits_for_hardly_any_time_is_held_to_longer_waits():
    waits = []
    hurried = Script(lambda agent, view, n: waits.append(n) or Wait((), 1e-9))
    _, end = result(line(3, goal=2, agents=[0], stall_seconds=50.0), policy=hurried)
    assert end.ended == "deadlock" and len(waits) < 100


def test_two_that_keep_each_other_awake_while_no_time_passes_are_an_error():
    policy = Script(lambda agent, view, n: Wait((0, 1, 2), 5.0, 1 - agent if n % 2 else 2))
    with pytest.raises(PluginError, match=r"policy 'script', agent [01] at 5 s: it has decided 10000 times to wait"):
        result(line(4, goal=3, agents=[0, 1]), policy=policy)
