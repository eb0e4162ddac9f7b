"""Our own backends keep the promises of the protocol, and the check catches those that do not."""

from __future__ import annotations

import pytest
from faulty_backends import FAULTS

from colonysim.backends.mock import Mock
from colonysim.backends.nodeworld import NodeWorld
from colonysim.errors import ColonysimError
from colonysim.testing import ConformanceError, check_backend, random_scenario
from colonysim.world.intents import Outcome


@pytest.mark.parametrize(
    "factory",
    [NodeWorld, Mock, lambda: Mock(tick=0.25), lambda: Mock(tick=0.3, seconds=2.0), lambda: Mock(script=[None])],
    ids=["nodeworld", "mock", "mock with a tick", "mock with an odd tick", "mock with a script"],
)
def test_our_own_keep_their_promises(factory):
    check_backend(factory)


def test_failures_are_no_faults():
    # Every third action of an agent fails, with a reason.
    def script(agent, intent, world):
        failed = world.agent_node[agent] % 3 == 0 and world.agent_from[agent] >= 0
        return Outcome("failed", world.agent_node[agent], reason="slipped") if failed else None

    check_backend(lambda: Mock(script=script))


@pytest.mark.parametrize(("factory", "promise"), FAULTS, ids=[factory.__name__ for factory, _ in FAULTS])
def test_a_broken_promise_is_named(factory, promise):
    with pytest.raises(ConformanceError) as caught:
        check_backend(factory, scenarios=[random_scenario(number, max_agents=3) for number in (11, 36)])
    assert caught.value.promise == promise, caught.value
    assert str(caught.value).startswith(f"{promise}: ")


def test_one_episode_is_not_enough():
    with pytest.raises(ColonysimError, match="from 2 to"):
        check_backend(Mock, episodes=1)


def test_a_backend_that_lacks_a_method_is_told_at_once() -> None:
    class Broken:
        name = "broken"

        def reset(self, world: object, streams: object) -> None: ...

    with pytest.raises(ConformanceError, match="is no backend: Broken has no method 'feasible'"):
        check_backend(Broken)  # type: ignore[arg-type]
