"""What others' parts do that no answer shows: leaving, failing at the close, fields that ride along, rows and words."""

from __future__ import annotations

import pytest

import colonysim
from colonysim.backends.nodeworld import NodeWorld
from colonysim.bench.brought import ExtraField, OwnWalk
from colonysim.errors import PluginError
from colonysim.pheromones import Write


class Leaves(OwnWalk):
    def decide(self, view, memory, random):
        raise SystemExit(0)


class Mute(OwnWalk):
    def decide(self, view, memory, random):
        class Wordless(Exception):  # noqa: N818
            def __str__(self):
                raise ValueError

        raise Wordless


class BadEnd(NodeWorld):
    name = "bad-end"

    def close(self):
        raise RuntimeError("at the close")


class Rows(NodeWorld):
    name = "rows"

    def __init__(self, *rows):
        super().__init__()
        self._rows = rows

    def rows(self):
        return self._rows


class Wordy(NodeWorld):
    name = "wordy"

    def start(self, agent, intent, now):
        done = super().start(agent, intent, now)
        return done._replace(outcome=done.outcome.__class__("failed", 0, reason="x" * 4000))


class Astray(ExtraField):
    def deposit(self, visit):
        return (Write(999, -1, 1.0),)


def run(**more):
    return colonysim.run("easy", episodes=1, trace=False, **more)


@pytest.mark.parametrize(("policy", "said"), [(Leaves, "SystemExit: 0"), (Mute, "raises Wordless$")])
def test_whoever_leaves_or_cannot_say_why_has_failed(policy, said):
    with pytest.raises(PluginError, match=said):
        run(policy=policy)


def test_what_went_wrong_first_is_what_is_told():
    with pytest.raises(PluginError, match="SystemExit"):
        run(policy=Leaves, backend=BadEnd())
    with pytest.raises(PluginError, match="at the close"):
        run(backend=BadEnd())


def test_a_field_that_rides_along_with_our_own_policy_is_looked_at_too():
    scenario = colonysim.load_scenario("easy", overrides={"policy.extra_fields": [f"{__name__}:Astray"]})
    with pytest.raises(PluginError, match=r"field 'X'.*there is no such node"):
        colonysim.run(scenario, episodes=1, trace=False)


@pytest.mark.parametrize(
    "row",
    [
        ("deposits", (0.0, 0, "Q", 0, -1, 1.0)), ("controls", (0.0, 2**80, "a", "b", 1)),
        ("controls", (float("nan"), 0, "a", "b", 1)), ("controls", (0.0, 0, "\ud800", "b", 1)), ("nothing", ()),
    ],
)  # fmt: skip
def test_a_backend_gives_rows_of_its_own_tables_only(row):
    with pytest.raises(PluginError, match="expected rows of poses and controls"):
        run(backend=Rows(row))


def test_words_that_no_reader_takes_are_refused():
    with pytest.raises(PluginError, match="in at most 1000 characters"):
        run(backend=Wordy())
