"""Our own push executors keep the promises of the protocol, and the check catches those that do not."""

from __future__ import annotations

import pytest
from faulty_executors import FAULTS, Sound

from colonysim.push.executors import make_executor
from colonysim.push.feasibility import load_feasibility
from colonysim.testing import ConformanceError, check_executor

pytestmark = pytest.mark.usefixtures("some_engine")


@pytest.mark.parametrize(
    "factory",
    [
        lambda: make_executor("staged"), lambda: make_executor("scripted"),
        lambda: make_executor("rl", gate=load_feasibility()), Sound,
    ],
    ids=["staged", "scripted", "rl", "sound"],
)  # fmt: skip
def test_our_own_keep_their_promises(factory):
    check_executor(factory)


@pytest.mark.parametrize(("factory", "promise"), FAULTS, ids=[factory.__name__ for factory, _ in FAULTS])
def test_a_broken_promise_is_named(factory, promise):
    with pytest.raises(ConformanceError) as caught:
        check_executor(factory)
    assert caught.value.promise == promise, caught.value
    assert str(caught.value).startswith(f"{promise}: push (flat): ")


def test_what_cannot_be_called_is_no_executor():
    with pytest.raises(ConformanceError, match="expected what can be called"):
        check_executor(lambda: None)
