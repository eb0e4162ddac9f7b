"""The mock backend does what its script says, and remembers what it was asked."""

from __future__ import annotations

import pytest

from colonysim import scenario_from_document, simulate
from colonysim.backends.mock import Mock
from colonysim.world.intents import Outcome, Travel

ROW = scenario_from_document(
    {
        "name": "row", "topology": {"kind": "line", "nodes": 4}, "agents": [0], "goal": 3, "max_steps": 9,
        "episodes": 2,
    }
)  # fmt: skip


@pytest.mark.parametrize("tick", [None, 0.25])
def test_a_script_in_order_then_the_rules_of_the_place(tick):
    body = Mock(script=[Outcome("failed", 0, reason="wedged"), None], tick=tick, seconds=2.0)
    events = list(simulate(ROW, backend=body, policy="random", seed=3))
    for episode in (1, 2):
        ends = [event for event in events if event.kind == "end" and event.episode == episode]
        assert [(e.status, e.reason) for e in ends][:2] == [("failed", "wedged"), ("arrived", "")]
        assert all(event.time - event.began == pytest.approx(2.0) for event in ends)
    assert body.calls[0].method == "reset"
    starts = [call for call in body.calls if call.method == "start"]
    assert starts[0][1:] == (0, Travel(1), 0.0)
    assert len(starts) == sum(event.kind == "end" for event in events)
    assert body.calls[-1].method == "close"
    assert (sum(call.method == "advance" for call in body.calls) > 0) == (tick is not None)


def test_a_function_sees_agent_intent_and_world():
    def script(agent, intent, world):
        assert isinstance(intent, Travel)
        return Outcome("blocked", world.agent_node[agent], reason="shut")

    events = list(simulate(ROW, backend=Mock(script=script), policy="random"))
    assert {event.reason for event in events if event.kind == "end"} == {"shut"}
    assert [event.status for event in events if event.kind == "episode"] == ["max_steps", "max_steps"]
