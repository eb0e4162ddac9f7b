"""Random timelines, groups and faults on random worlds: checked, run, or refused with one message."""

import json
import random

import pytest
from test_mutations import told

from colonysim.testing.timelines import random_changes
from colonysim.testing.worlds import random_document

WRONG = [
    ("time", -1), ("time", "soon"), ("episode", 0), ("when", {"filled": 10**6}), ("when", {}), ("add_edge", [0]),
    ("move_goal", 10**6), ("remove_box", 99), ("fail", {"agents": []}), ("wipe", {"within": [0, 0]}), ("no_such", 1),
]  # fmt: skip
FAULTS = {
    "move_fails": 0.05, "box_missed": 0.1, "node_misplaced": 0.2, "mark_lost": 0.1, "mark_noise": 0.1,
    "stops": {"every": 60, "seconds": 5},
}  # fmt: skip


def worlds(count, seed):
    """Documents with a timeline, some of them with groups and faults, one in three with a mistake in the timeline."""
    for number in range(count):
        rng = random.Random(f"timelines/{seed}/{number}")
        document = random_document(rng)
        document["changes"] = random_changes(rng, document)
        if rng.random() < 0.3:
            first, *others = document.pop("agents")
            document["groups"] = [
                {"name": "one", "agents": [first], "speed": rng.choice([0.5, 1, 2]), "pushes": rng.random() < 0.5},
                *([{"name": "others", "agents": others, "ignores": rng.choice([[], ["D"], ["E"]])}] if others else []),
            ]
        if rng.random() < 0.3:
            document["faults"] = FAULTS
        if number % 3 == 2:
            field, value = rng.choice(WRONG)
            document["changes"][rng.randrange(len(document["changes"]))][field] = value
        yield document


def play(folder, count, runs, seed):
    """How many of so many worlds `validate` accepts; so many of them are run."""
    accepted = []
    for number, document in enumerate(worlds(count, seed)):
        path = folder / f"t{number}.yaml"
        path.write_text(json.dumps(document))
        code, _ = told(["validate", str(path)])
        if code == 0:
            accepted.append(path)
    for number, path in enumerate(accepted[:runs]):
        mode = ["asynchronous", "synchronous"][number % 2]
        assert told(["run", str(path), "--no-trace", "--quiet", "--mode", mode, "--seed", str(number)])[0] == 0
    return len(accepted)


def test_some_timelines_are_valid_and_run(tmp_path):
    assert play(tmp_path, 60, 20, 1) >= 40


@pytest.mark.slow
def test_many_timelines_are_checked_and_run(tmp_path):
    assert play(tmp_path, 1000, 200, 2) >= 650
