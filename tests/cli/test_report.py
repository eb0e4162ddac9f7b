"""`report`: the failed pushes and travels of a run, and the agents that did not reach the goal."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from core.small_worlds import Script
from recorded_runs import manifest
from typer.testing import CliRunner, Result

import colonysim
from colonysim.backends.mock import Mock
from colonysim.cli import app
from colonysim.policies.view import LocalView
from colonysim.trace.schema import EpisodeResult, Event
from colonysim.trace.writer import TraceWriter
from colonysim.world.intents import Intent, Outcome, Push, Travel, Wait


def report(*words: object) -> Result:
    return CliRunner().invoke(app, ["report", *(str(word) for word in words)])


def told(*words: object) -> Any:
    result = report(*words, "--json")
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


def end(episode: int, time: float, agent: int, action: str, way: tuple[int, int], status: str, reason: str) -> Event:
    box, hole = (-1, -1) if action == "travel" else (2, 9)
    return Event(episode, time, "end", agent, action, *way, box, hole, status, reason)


EVENTS = [
    Event(1, 0.0, "start", 0, node=3),
    *(end(1, 1.0 + i, 0, "travel", (3, 4), "arrived", "") for i in range(7)),
    end(1, 8.5, 1, "push", (5, 6), "failed", "wedged"),
    end(1, 9.0, 1, "push", (5, 6), "arrived", ""),
    Event(1, 9.5, "wait", 1, "wait", 5, 6),
    end(2, 2.25, 0, "travel", (3, 4), "blocked", "timeout"),
    end(2, 3.0, 2, "travel", (4, 7), "blocked", "timeout"),
    end(3, 4.0, 2, "take", (1, 5), "failed", ""),
]


def write(directory: Path, events: list[Event], **changes: Any) -> TraceWriter:
    directory.mkdir()
    known = {"backend": "bullet", "policy": "colony", "seed": 4, "status": "running"}
    writer = TraceWriter(directory, manifest(**known | changes))
    for event in events:
        writer.write("events", event)
    return writer


@pytest.fixture
def recorded(tmp_path: Path) -> Path:
    with write(tmp_path / "run", EVENTS) as writer:
        writer.write("episodes", EpisodeResult(1, 9, 1.0, "goal", 9.5, 0, 0.1))
    return tmp_path / "run"


def test_json_is_one_object_that_counts_the_failures_and_names_each(recorded: Path) -> None:
    found = told(recorded)
    assert list(found) == [
        "run", "scenario", "backend", "policy", "seed", "status", "episodes", "attempts", "by", "summary", "failures",
        "stranded",
    ]  # fmt: skip
    assert found["attempts"] == {"travel": 9, "take": 1, "push": 2} and found["episodes"] == [1, 2, 3]
    most, *rest = found["summary"]
    assert (most["action"], most["reason"], most["count"], most["attempts"]) == ("travel", "timeout", 2, 9)
    assert (most["low"], most["share"], most["high"]) == pytest.approx((0.0632, 2 / 9, 0.5474), abs=1e-4)
    assert [(kind["action"], kind["reason"], kind["share"]) for kind in rest] == [
        ("push", "wedged", 0.5),
        ("take", "(none told)", 1.0),
    ]
    assert [(e["episode"], e["time"], e["agent"], e["from"], e["to"]) for e in found["failures"]] == [
        (1, 8.5, 1, 5, 6), (2, 2.25, 0, 3, 4), (2, 3.0, 2, 4, 7), (3, 4.0, 2, 1, 5),
    ]  # fmt: skip
    assert most["first"] == found["failures"][1]
    assert (found["failures"][0]["box"], found["failures"][0]["hole"]) == (2, 9)
    assert found["failures"][1]["box"] is None


def test_the_share_by_edge_or_agent_is_that_of_the_attempts_there(recorded: Path) -> None:
    by_edge = {(kind["action"], kind["edge"]): kind for kind in told(recorded, "--by", "edge")["summary"]}
    assert {key: (kind["count"], kind["attempts"]) for key, kind in by_edge.items()} == {
        ("travel", "3-4"): (1, 8), ("travel", "4-7"): (1, 1), ("push", "5-6"): (1, 2), ("take", "1-5"): (1, 1),
    }  # fmt: skip
    assert by_edge["push", "5-6"]["reasons"] == {"wedged": 1}
    by_agent = {(kind["action"], kind["agent"]): kind for kind in told(recorded, "--by", "agent")["summary"]}
    assert (by_agent["travel", 0]["count"], by_agent["travel", 0]["attempts"]) == (1, 8)


def test_the_table_says_the_same(recorded: Path) -> None:
    result = report(recorded)
    assert "4 of 12 attempts failed in 3 episodes (travel 9, take 1, push 2)" in result.stdout
    assert "2 of 9" in result.stdout and "0.0632 to 0.5474" in result.stdout
    assert "episode 2, 2.2 s, 3-4" in result.stdout
    assert result.stdout.index("8.5") > result.stdout.index("0.5474")  # each failure below the counts
    assert "wedged 1" in report(recorded, "--by", "edge").stdout


def test_episodes_can_be_chosen(recorded: Path) -> None:
    found = told(recorded, "--episodes", "2-3")
    assert found["attempts"] == {"travel": 2, "take": 1, "push": 0}
    assert found["episodes"] == [2, 3] and len(found["failures"]) == 3


def test_a_run_that_was_killed_is_reported_as_far_as_it_came(tmp_path: Path) -> None:
    writer = write(tmp_path / "run", EVENTS)
    writer.flush()
    assert not (tmp_path / "run/episodes").exists()
    assert "running or killed after 0 of 3 episodes: 4 of 12 attempts failed" in report(tmp_path / "run").stdout


def test_nothing_failed_and_nothing_happened(tmp_path: Path) -> None:
    with write(tmp_path / "fine", EVENTS[:8]):
        pass
    assert "0 of 7 attempts failed in 1 episode (" in report(tmp_path / "fine").stdout
    assert told(tmp_path / "fine")["summary"] == told(tmp_path / "fine")["failures"] == []
    with write(tmp_path / "empty", []):
        pass
    assert "0 of 0 attempts failed in 0 episodes" in report(tmp_path / "empty").stdout


def test_single_pushes_are_placed_by_their_terrain(tmp_path: Path) -> None:
    ground = {"box_length": 0.5, "start": [0, 0], "goal": [1, 0], "pits": [], "ramps": []}
    pushes = [{"episode": n, "terrain": kind, **ground} for n, kind in ((1, "flat"), (2, "hole"))]
    evaluation = {"executor": "rl", "robot_size": [0.6, 0.4], "pushes": pushes}
    ends = [Event(n, 5.0, "end", 0, "push", box=0, status="failed", reason="timeout", step=1) for n in (1, 2)]
    with write(tmp_path / "pushes", ends, evaluation=evaluation, episodes=2):
        pass
    found = told(tmp_path / "pushes", "--by", "edge")
    assert [(kind["edge"], kind["count"]) for kind in found["summary"]] == [("flat", 1), ("hole", 1)]
    assert found["failures"][0]["from"] is None
    assert "episode 2, 5.0 s, hole" in report(tmp_path / "pushes", "--by", "edge").stdout


def test_failures_of_a_colony_are_found(tmp_path: Path) -> None:
    scenario = colonysim.load_scenario("sanity")
    start = scenario.agents[0]
    body = Mock(script=[Outcome("failed", start, reason="slipped")])
    colonysim.run(scenario, backend=body, episodes=1, seed=3, out=tmp_path / "run")
    (failure,) = told(tmp_path / "run")["failures"]
    assert (failure["reason"], failure["time"]) == ("slipped", 1.0)
    assert failure["from"] == scenario.topology.ids[start]


ROW = {
    "name": "row", "nodes": [[10 + i, i, 0] for i in range(6)], "edges": [[10 + i, 11 + i] for i in range(5)],
    "agents": [10], "goal": 15, "max_steps": 20, "episodes": 1, "timing": {"jitter": 0.0},
}  # fmt: skip


def stranded(tmp_path: Path, act: Callable[[int, LocalView, int], Intent], **changes: Any) -> list[dict[str, Any]]:
    backend = changes.pop("backend", "nodeworld")
    scenario = colonysim.scenario_from_document(ROW | changes)
    colonysim.run(scenario, backend=backend, policy=Script(act), seed=3, out=tmp_path / "run")
    found: list[dict[str, Any]] = told(tmp_path / "run")["stranded"]
    for agent in found:
        assert agent["why"] in " ".join(report(tmp_path / "run").stdout.split())
    return found


def test_who_goes_to_and_fro_until_its_steps_are_used_up_is_named_without_a_failure(tmp_path: Path) -> None:
    (agent,) = stranded(tmp_path, lambda agent, view, n: Travel(view.node + 1 if n < 3 or n % 2 else view.node - 1))
    assert agent["nodes"] == [13, 14] or agent["nodes"] == [14, 13]
    assert (agent["episode"], agent["agent"], agent["ended"], agent["state"]) == (1, 0, "max_steps", "steps used up")
    assert agent["attempts"] == {"travel": 17} and agent["failures"] == {} and agent["way_open"]
    assert agent["since"] == 3.0 and agent["until"] == 20.0
    assert agent["why"].endswith("travel 17, all arrived; the goal could be reached on foot from there")


def test_who_waits_at_the_end_is_told_with_the_node_and_whether_the_way_was_open(tmp_path: Path) -> None:
    def act(agent: int, view: LocalView, n: int) -> Intent:
        return Travel(view.node + 1) if n < 2 else Wait((view.node + 1,))

    (agent,) = stranded(tmp_path, act, holes=[{"node": 13, "depth": 1.0}], boxes=[[14, 1.0]])
    assert (agent["ended"], agent["state"], agent["node"], agent["waits_for"]) == ("deadlock", "waiting", 12, 13)
    assert not agent["way_open"] and agent["attempts"] == {"travel": 2}
    assert agent["why"].endswith(
        "at node 12 it waits for a change at node 13 from 2.0 s; the goal could not be reached on foot from there"
    )


def test_a_filled_hole_is_on_the_way(tmp_path: Path) -> None:
    def act(agent: int, view: LocalView, n: int) -> Intent:
        return Push(0, n + 1, 0) if n < 2 else Travel(view.node + (1 if n % 2 else -1))

    (agent,) = stranded(tmp_path, act, holes=[{"node": 12, "depth": 1.0}], boxes=[[11, 1.0]])
    assert agent["way_open"] and agent["attempts"]["push"] == 1, agent


def test_a_lost_agent_is_told_with_the_reason(tmp_path: Path) -> None:
    body = Mock(script=[Outcome("failed", 0, reason="on its back", lost=True)])
    (agent,) = stranded(tmp_path, lambda agent, view, n: Travel(view.node + 1), backend=body)
    assert agent["state"] == "lost" and agent["why"] == "lost at node 10: on its back"


def test_who_is_at_the_goal_or_interrupted_is_not_stranded(tmp_path: Path) -> None:
    assert stranded(tmp_path, lambda agent, view, n: Travel(view.node + 1)) == []

    def stop(event: Event, run: colonysim.Run) -> None:
        if event.time > 2:
            raise KeyboardInterrupt

    scenario = colonysim.scenario_from_document(ROW)
    with pytest.raises(KeyboardInterrupt):
        colonysim.run(scenario, seed=3, out=tmp_path / "stopped", on_event=stop)
    assert told(tmp_path / "stopped")["stranded"] == []


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--episodes", "4"), "no episode 4 in this run; it has 1 to 3"),
        (("--episodes", "many"), "no list of numbers"),
        (("--by", "reson"), "'reason'"),
    ],
)
def test_mistakes_are_told_with_exit_code_2(recorded: Path, words: tuple[str, ...], said: str) -> None:
    result = report(recorded, *words)
    assert result.exit_code == 2 and said in result.stderr and not result.stdout


def test_what_is_no_run_is_refused(tmp_path: Path) -> None:
    for place, said in ((tmp_path / "nowhere", "no such run directory"), (tmp_path, "not a run directory")):
        result = report(place)
        assert result.exit_code == 2 and said in result.stderr and "Traceback" not in result.output
