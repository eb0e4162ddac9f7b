"""The first episode on each map as text: a change of behaviour shows as a readable difference.

After a change that is meant: python tests/core/test_golden_traces.py
"""

from __future__ import annotations

import difflib
from pathlib import Path

import pytest
from small_worlds import play

from colonysim import load_scenario
from colonysim.trace.schema import Event

GOLDEN = Path(__file__).parent / "golden"
MAPS = ("sanity", "easy", "medium", "hard")
SEED = 1


def sentence(event: Event) -> str:
    """One line: when, who, what, where."""
    clock, who = f"{event.time:10.6f}", f"agent {event.agent}"
    if event.kind == "episode":
        return f"{clock}  episode ended: {event.status}, {event.step} steps"
    if event.kind == "wait":
        return f"{clock}  {who} waits on {event.node}" + (f" for {event.target}" if event.target >= 0 else "")
    if event.kind != "end":
        return f"{clock}  {who} {event.kind} on {event.node}"
    what = {"travel": "travelled", "take": f"took box {event.box}", "push": f"pushed box {event.box}"}[event.action]
    aim = f" for hole {event.hole}" if event.hole >= 0 else ""
    end = "" if event.status == "arrived" else f", {event.status}: {event.reason}"
    stays = ", stays behind" if event.status == "arrived" and event.now_at != event.target else ""
    return f"{clock}  {who} {what} {event.node}-{event.target}{aim} (step {event.step}){stays}{end}"


def trace(name: str) -> str:
    events, _ = play(load_scenario(name), episodes=1, seed=SEED)
    return "".join(f"{sentence(event)}\n" for event in events)


@pytest.mark.parametrize("name", MAPS)
def test_the_first_episode_is_the_golden_one(name):
    wanted = (GOLDEN / f"{name}.txt").read_text(encoding="utf-8")
    found = trace(name)
    if found != wanted:
        lines = (wanted.splitlines(), found.splitlines())
        difference = difflib.unified_diff(*lines, f"golden/{name}.txt", "now", lineterm="")
        pytest.fail("\n".join(list(difference)[:40]), pytrace=False)


if __name__ == "__main__":
    GOLDEN.mkdir(exist_ok=True)
    for name in MAPS:
        (GOLDEN / f"{name}.txt").write_text(trace(name), encoding="utf-8")
