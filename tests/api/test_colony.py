"""A colony that is held: stepped, looked at, measured, and gone on with."""

from __future__ import annotations

import gc
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import colonysim
from colonysim import Colony, ColonysimError, simulate
from colonysim.backends.nodeworld import NodeWorld
from colonysim.trace.reader import Run


def test_step_by_step_it_is_the_same_as_simulate(backend: str) -> None:
    scenario = colonysim.load_scenario("sanity")
    whole = list(simulate(scenario, backend=backend, seed=4, episodes=2))
    colony, events = Colony("sanity", backend=backend, seed=4, episodes=2), []
    while (event := colony.step()) is not None:
        events.append(event)
    assert events == whole and colony.over and colony.step() is None
    mixed = Colony(scenario, backend=backend, seed=4, episodes=2)
    first = [mixed.step() for _ in range(3)]
    time = whole[len(whole) // 4].time
    mixed.run_until(time=time)
    mixed.run_until(event="goal")
    rest = list(mixed)
    assert first == whole[:3] and rest == whole[len(whole) - len(rest) :] and rest


def test_until_a_time_everything_due_has_happened_and_nothing_else() -> None:
    events = list(simulate(colonysim.load_scenario("hard"), seed=1, episodes=1))
    colony, told = Colony("hard", seed=1, episodes=1), []
    for kind in colonysim.trace.schema.EVENT_KINDS:
        colony.on(kind, lambda event, _: told.append(event))
    for time in (0.0, 3.0, 3.5, 9.999, 30.0):
        colony.run_until(time=time)
        assert told == [event for event in events if event.time <= time]
        assert colony.now == time and colony.episode == 1 and not colony.over
    assert colony.run_until(time=1e6) == events[-1]
    assert colony.now == events[-1].time < 1e6


def test_until_an_event_or_an_episode() -> None:
    colony = Colony("easy", seed=2, episodes=3)
    event = colony.run_until(event="arrive")
    assert event is not None and (event.kind, event.status) == ("end", "arrived")
    event = colony.run_until(event=lambda event: event.kind == "goal" and event.agent == 1)
    assert event is not None and event.agent == 1
    event = colony.run_until(episode=2)
    assert event is not None and (event.kind, event.episode, colony.episode) == ("episode", 2, 2)
    assert colony.run_until(episode=1) is None, "it has ended long ago"
    assert colony.run_until(episode=3) is not None and colony.over
    assert colony.run_until(event="goal") is None


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({}, "one of time, event and episode"),
        ({"time": 1.0, "episode": 1}, "time and episode"),
        ({"time": -1}, "time: -1"),
        ({"time": math.nan}, "time: nan"),
        ({"time": True}, "time: True"),
        ({"episode": 9}, "episode: 9"),
        ({"episode": 1.5}, "whole number"),
        ({"event": "arrives"}, "did you mean 'arrive'"),
    ],
)
def test_what_cannot_be_waited_for(asked: dict[str, object], words: str) -> None:
    with pytest.raises(ColonysimError, match=words):
        Colony("sanity", episodes=2).run_until(**asked)  # type: ignore[arg-type]


def test_what_is_shown_is_what_the_events_tell(backend: str) -> None:
    colony = Colony("medium", backend=backend, seed=3, episodes=1)
    scenario = colony.scenario
    ids = scenario.topology.ids
    nodes = np.array([ids[node] for node in scenario.agents])
    boxes = np.array([ids[box.node] for box in scenario.boxes])
    steps = np.zeros(len(nodes), dtype=int)
    assert (colony.agents.node == nodes).all() and (colony.boxes.node == boxes).all() and colony.now == 0.0
    for _, event in zip(range(60), colony, strict=False):
        if event.kind == "end":
            nodes[event.agent] = event.now_at
            if event.action == "push" and event.status == "arrived":
                boxes[event.box] = event.target
        if event.agent >= 0:
            steps[event.agent] = max(event.step, steps[event.agent])
        assert (colony.agents.node == nodes).all() and (colony.agents.steps >= steps).all()
        assert (colony.boxes.node == boxes).all() or backend != "nodeworld"
    held = colony.agents.held_box
    for agent, box in enumerate(held):
        assert box < 0 or colony.boxes.holder[box] in (agent, -1)
    place = colony.world
    assert colony.agents.position.shape == (len(nodes), 3) and place.position.shape == (len(ids), 3)
    assert (place.occupant[[ids.index(node) for node in nodes]] >= 0).all() or "goal" in colony.agents.status
    assert place.goal == ids[scenario.goal] and place.reachable(int(nodes[0]), int(nodes[0])) is False


def test_what_is_shown_cannot_be_changed_and_does_not_change() -> None:
    colony = Colony("hard", seed=1)
    before = colony.agents.node
    with pytest.raises(ValueError, match="read-only"):
        before[0] = 1
    kept = before.copy()
    colony.run_until(time=10)
    assert (before == kept).all() and (colony.agents.node != kept).any()
    with pytest.raises(AttributeError):
        colony.agents.node = kept  # type: ignore[misc]
    with pytest.raises(TypeError):
        colony.fields["D"] = colony.fields["E"]  # type: ignore[index]


def test_fields_are_those_that_the_run_records(tmp_path: Path) -> None:
    run = colonysim.run("hard", seed=5, episodes=1, out=tmp_path / "run")
    colony = Colony("hard", seed=5, episodes=1)
    colony.run_until(episode=1)
    assert list(colony.fields) == ["D", "B", "H", "E"]
    for name, field in colony.fields.items():
        told = {key if isinstance(key, tuple) else (key, -1): value for key, value in run.field(name).items()}
        assert field.items() == told and told
    ids = list(colony.world.node)
    values = colony.fields["D"].values()
    assert values[ids.index(colony.world.goal)] == colony.fields["D"].at(colony.world.goal) == values.max()
    hole = int(colony.world.holes[0])
    assert (colony.fields["H"].values(hole) >= 0).all() and colony.fields["B"].values(hole).shape == (4,)
    for name in ("H", "B"):
        with pytest.raises(ColonysimError, match="has a value for each hole: name the node of one"):
            colony.fields[name].values()
    for wrong in ({"place": 10**6, "hole": hole}, {"place": ids[0], "hole": ids[0]}, {"place": ids[0], "hole": -7}):
        with pytest.raises(KeyError):
            colony.fields["H"].at(**wrong)
    with pytest.raises(KeyError):
        colony.fields["B"].at(99, hole)


def test_observers_hear_their_kind_until_they_are_let_go() -> None:
    heard: list[str] = []
    colony = Colony("hard", seed=1, episodes=2)
    end = colony.on("goal", lambda event, held: heard.append(f"{event.agent} {held.agents.status[event.agent]}"))
    colony.run_until(episode=1)
    assert len(heard) == 4 and all(words.endswith("goal") for words in heard)
    end()
    colony.run_until(episode=2)
    assert len(heard) == 4
    with pytest.raises(ColonysimError, match="leaves them out"):
        Colony("hard", kinds=["episode"]).on("arrive", print)
    with pytest.raises(ColonysimError, match="did you mean 'goal'"):
        colony.on("gaol", print)


def test_what_an_observer_raises_ends_the_colony() -> None:
    colony = Colony("hard", seed=1)

    def fail(event: object, held: object) -> None:
        raise RuntimeError("no more")

    colony.on("goal", fail)
    with pytest.raises(RuntimeError, match="no more"):
        list(colony)
    assert colony.over and colony.step() is None


def test_neither_observers_nor_measurements_move_the_colony() -> None:
    for call in (lambda held: held.step(), lambda held: held.run_until(time=99), lambda held: held.close()):
        for place in ("on", "measure"):
            colony = Colony("sanity", episodes=1)
            if place == "on":
                colony.on("end", lambda event, held, call=call: call(held))
            else:
                colony.measure("moves", call, every=1.0)
            with pytest.raises(ColonysimError, match="a colony cannot"):
                list(colony)


def test_nor_do_they_while_events_are_waiting_to_be_handed_out() -> None:
    """All agents start at second 0: four events come at once, and the first observer is told of the first of them."""
    whole = list(Colony("hard", seed=1, episodes=1))
    for call in (lambda held: held.step(), lambda held: next(iter(held)), lambda held: held.run_until(event="goal")):
        colony = Colony("hard", seed=1, episodes=1)
        colony.on("start", lambda event, held, call=call: call(held))
        with pytest.raises(ColonysimError, match="cannot go on while it waits for an observer"):
            list(colony)
        colony = Colony("hard", seed=1, episodes=1)
        refused: list[str] = []

        def attempt(held: Colony, call: Any = call, refused: list[str] = refused) -> float:
            try:
                call(held)
            except ColonysimError as error:
                refused.append(str(error))
            return 0.0

        colony.measure("moves", attempt)
        assert list(colony) == whole and len(refused) == 1


def test_until_a_time_stops_at_the_episode_s_end_whatever_is_handed_out() -> None:
    for kinds in (None, ["goal"], ["episode"], ["wait"], []):
        colony = Colony("hard", seed=1, episodes=3, kinds=kinds)
        colony.run_until(time=1e6)
        assert colony.episode == 1 and not colony.over and not colony.completed, kinds
        colony.run_until(time=3.0)
        assert colony.episode == 2 and colony.now == 3.0, kinds
    with pytest.raises(ColonysimError, match="leaves them out"):
        Colony("hard", kinds=["goal"]).run_until(episode=1)


def test_fields_fade_up_to_now() -> None:
    colony = Colony(colonysim.load_scenario("hard", None, {"policy.exploration_half_life": 2.0}), seed=1)
    colony.run_until(time=12.0)
    node = int(colony.agents.node[0])
    before, last = colony.fields["E"].values(), max(colony.now, 12.0)
    colony.run_until(time=12.0 + 1e-3)
    assert last == 12.0 and (colony.fields["E"].values() <= before + 1.0).all() and node >= 0
    others = colony.fields["E"].values() < before
    assert (colony.fields["E"].values()[others] / before[others] == pytest.approx(0.5 ** (1e-3 / 2.0), rel=1e-12))


def test_the_end_of_an_episode_is_its_time(tmp_path: Path) -> None:
    rows = []
    colony = Colony(colonysim.load_scenario("hard", None, {"time_limit": 5.25}), seed=1, episodes=1)
    colony.measure("now", lambda held: held.now, every=0.5)
    rows = [event for event in colony if event.kind == "episode"]
    assert rows[0].time == 5.25 == colony.now and colony.measurements[-1][1:] == (5.25, "now", 5.25)
    assert [row.time for row in colony.measurements] == [*(0.5 * k for k in range(1, 11)), 5.25]


def test_a_colony_that_nobody_closes_lets_go_of_its_backend() -> None:
    class Watched(NodeWorld):
        closed = 0

        def close(self) -> None:
            type(self).closed += 1

    body = Watched()
    colony = Colony("hard", seed=1, backend=body)
    colony.step()
    with pytest.raises(ColonysimError, match="moves another colony"):
        Colony("hard", seed=1, backend=body)
    del colony
    gc.collect()
    assert Watched.closed == 1
    Colony("hard", seed=1, backend=body).close()
    assert Watched.closed == 2


def test_a_run_whose_colony_is_closed_early_is_not_finished(tmp_path: Path) -> None:
    with pytest.raises(ColonysimError, match="closed before its last episode"):
        colonysim.run("hard", seed=1, episodes=2, out=tmp_path / "run", on_begin=lambda held: held.close())
    assert not (tmp_path / "run").exists() or Run.open(tmp_path / "run").status == "failed"


@pytest.mark.parametrize("wrong", [5, None, {}])
def test_what_is_no_scenario(wrong: object) -> None:
    with pytest.raises(ColonysimError, match="expected a scenario"):
        Colony(wrong)  # type: ignore[arg-type]


def test_measurements_are_a_table_of_the_run(tmp_path: Path) -> None:
    def prepare(colony: Colony) -> None:
        colony.measure("there", lambda held: (held.agents.status == "goal").sum(), every=10.0)
        colony.measure("seated", lambda held: held.world.filled.mean())

    run = colonysim.run("hard", seed=1, episodes=2, out=tmp_path / "run", on_begin=prepare)
    plain = colonysim.run("hard", seed=1, episodes=2, trace=False)
    rows = Run.open(tmp_path / "run").table("measurements").to_pylist()
    assert run.verify() and [e[:6] for e in run.episodes] == [e[:6] for e in plain.episodes]
    assert run.trace_sha256 != plain.trace_sha256, "they are a part of the trace"
    for episode in (1, 2):
        of = [row for row in rows if row["episode"] == episode]
        seconds = run.episodes[episode - 1].sim_seconds
        regular = [row["time"] for row in of if row["name"] == "there"]
        assert regular == [*(10.0 * k for k in range(1, int(seconds // 10) + 1)), seconds]
        assert [row["value"] for row in of if row["name"] == "seated"] == [1.0]
        assert [row["value"] for row in of if row["name"] == "there"][-1] == 4.0


def test_who_measures_nothing_keeps_the_hash(tmp_path: Path) -> None:
    run = colonysim.run("sanity", seed=1, episodes=1, out=tmp_path / "run")
    assert run.manifest["rows"]["measurements"] == 0 and run.verify()
    assert run.table("measurements").num_rows == 0


@pytest.mark.parametrize("value", ["many", None, True, 10**400, np.array([1.0, 2.0])])
def test_a_measurement_that_is_no_number(value: object) -> None:
    colony = Colony("sanity", episodes=1)
    colony.measure("wrong", lambda held: value)  # type: ignore[arg-type, return-value]
    with pytest.raises(ColonysimError, match=r"'wrong' is .*, expected a number"):
        list(colony)


def test_measurements_that_cannot_be() -> None:
    colony = Colony("sanity", episodes=1)
    colony.measure("one", lambda held: 1.0)
    for name, every in (
        ("one", None), ("", None), ("a" * 1001, None), ("\ud800", None), ("two", 0.0), ("two", -1.0), ("two", math.inf),
        ("two", "often"), ("two", 1e-300), ("two", True),
    ):  # fmt: skip
        with pytest.raises(ColonysimError, match="measure: "):
            colony.measure(name, lambda held: 1.0, every=every)  # type: ignore[arg-type]


def test_a_closed_colony_can_be_looked_at() -> None:
    with Colony("hard", seed=1) as colony:
        colony.run_until(time=10)
    assert colony.step() is None and colony.over
    assert len(colony.agents.node) == 4 and "episode 1" in repr(colony)
    colony.close()


def test_the_picture_shows_what_is_where() -> None:
    colony = Colony("hard", seed=1)
    assert colony._repr_html_().count("<title>agent") == 4
    colony.run_until(time=30)
    there = int((colony.agents.status == "goal").sum())
    assert colony._repr_html_().count("<title>agent") == 4 - there and there
    assert f"{there} of 4 agents at the goal" in repr(colony) and len(repr(colony)) < 100
