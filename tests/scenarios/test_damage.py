"""Damaged files and documents are either still good or refused with a message; nothing else ever happens."""

# ruff: noqa: E501 - tables

import copy
import json
import random
from pathlib import Path

import pytest

from colonysim.errors import ScenarioError
from colonysim.scenario.loading import load_scenario, scenario_from_document

SNIPPETS = [
    "", " ", "\n", "\t", ":", "-", "[", "]", "{", "}", ",", "#", "&a ", "*a", "!!str ", "!x ", "|", ">", "'", '"', "%", "@",
    "null", ".nan", "1e400", "-1", "0", "99", "9" * 30, "true", "<<: ", "? ", "---\n", "...\n", "\x00", "\u2028", "é", "\ufeff",
]  # fmt: skip
JUNK = [
    None, True, -1, 0, 0.5, 99, 10**30, 1e300, "", "x", "0", [], {}, [0], [0, 1], [0, 1, 2], [[]], [None], {"node": 0}, {"kind": "grid"},
    {"": 1}, [[0, 0, 0, 0, 0]], "variants", {"name": 3}, [{"id": 1}], {"radius": 1}, {"file": "x"}, "\x00", "\ud800",
]  # fmt: skip


def message_of(call):
    """What the call is refused with, or nothing."""
    try:
        call()
    except ScenarioError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("name", ["sanity", "hard"])
def test_damaged_text(name, tmp_path):
    text = Path(load_scenario(name).source).read_text(encoding="utf-8")
    rng = random.Random(2)
    path = tmp_path / "damaged.yaml"
    refusals = 0
    for _ in range(250):
        damaged = text
        for _ in range(rng.randint(1, 3)):
            at = rng.randrange(len(damaged))
            damaged = damaged[:at] + rng.choice(SNIPPETS) + damaged[at + rng.randint(0, 5) :]
        path.write_text(damaged, encoding="utf-8", newline="")
        message = message_of(lambda: load_scenario(path))
        refusals += bool(message)
        assert not message or message.startswith(f"{path}:")
    assert refusals > 80


@pytest.mark.parametrize("name", ["sanity", "hard"])
def test_damaged_documents(name):
    sound = json.loads(json.dumps(load_scenario(name).document))
    sound |= {"timing": {"travels": [[0, 1, 2]]}, "policy": {"name": "x"}, "variants": {"a": {"goal": 3}}}
    rng = random.Random(3)
    for _ in range(600):
        document = copy.deepcopy(sound)
        here = document
        while True:
            keys = list(here) if isinstance(here, dict) else range(len(here))
            key = rng.choice(list(keys))
            if isinstance(here[key], (dict, list)) and here[key] and rng.random() < 0.75:
                here = here[key]
            else:
                break
        here[key] = copy.deepcopy(rng.choice(JUNK))
        message = message_of(lambda: scenario_from_document(document))  # noqa: B023 - called at once
        assert not message or message.startswith("<document>: ")


def test_overrides_with_junk():
    rng = random.Random(4)
    paths = ["goal", "agents.0", "nodes.3", "nodes.3.1", "edges", "edges.radius", "topology.kind", "physics.terrain.pits.0",
             "timing", "policy", "policy.a.b.c", "holes.0.depth", "x.y", "", ".", "a..b", "variants", "boxes.-1"]  # fmt: skip
    for _ in range(400):
        path, junk = rng.choice(paths), rng.choice(JUNK)
        message_of(lambda: load_scenario("sanity", overrides={path: junk}))  # noqa: B023 - called at once
        message_of(lambda: load_scenario("sanity", overrides=[f"{path}={rng.choice(SNIPPETS)}"]))  # noqa: B023
