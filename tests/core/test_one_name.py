"""A policy or backend has one name in tables and comparisons, however it was asked for."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest

import colonysim
from colonysim.backends.mock import Mock
from colonysim.backends.nodeworld import NodeWorld
from colonysim.errors import ColonysimError
from colonysim.plugins import called, load, make_policy
from colonysim.policies.presets import Colony
from colonysim.sweep import run_sweep
from colonysim.sweep.comparing import compare
from colonysim.sweep.plan import plan_sweep
from colonysim.sweep.tables import read_table

SOURCE = """
from colonysim.backends.nodeworld import NodeWorld
from colonysim.policies.presets import Colony

class Says(Colony):
    name = "mine"

class Inherits(Colony):
    pass

class Claims(Colony):
    name = "paper"

class Also(Colony):
    name = "mine"

class World(NodeWorld):
    name = "my-world"

def make(scenario):
    return Colony(scenario)
"""


@pytest.fixture
def mine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    (tmp_path / "one_name.py").write_text(SOURCE)
    monkeypatch.syspath_prepend(str(tmp_path))
    yield "one_name"
    sys.modules.pop("one_name", None)


def test_every_way_to_ask_gives_one_name(mine: str) -> None:
    scenario = colonysim.load_scenario("sanity")
    for name, expected in (("Says", "mine"), ("Inherits", f"{mine}:Inherits"), ("Claims", f"{mine}:Claims")):
        kind = load("policies", f"{mine}:{name}")
        own = colonysim.load_scenario("sanity", None, {"policy.name": f"{mine}:{name}"})
        runs = [
            colonysim.run(scenario, policy=given, episodes=1, trace=False)
            for given in (f"{mine}:{name}", kind, kind(scenario), partial(kind))
        ]
        runs.append(colonysim.run(own, episodes=1, trace=False))
        assert {run.manifest["policy"] for run in runs} == {expected}
    for given in (f"{mine}:make", load("policies", f"{mine}:make")):
        assert colonysim.run(scenario, policy=given, episodes=1, trace=False).manifest["policy"] == f"{mine}:make"
    for policy in ("colony", "colonysim.policies.presets:Colony", Colony, Colony(scenario), lambda s: Colony(s)):
        assert called("policies", policy, make_policy(policy, scenario)) == "colony"
    for body, told in ((NodeWorld(), "nodeworld"), ("colonysim.backends.nodeworld:NodeWorld", "nodeworld"),
                       (f"{mine}:World", "my-world"), (load("backends", f"{mine}:World")(), "my-world")):  # fmt: skip
        assert colonysim.run(scenario, backend=body, episodes=1, trace=False).manifest["backend"] == told
    assert called("backends", "mock", Mock) == called("backends", Mock(), Mock()) == "mock"


def test_runs_of_one_policy_are_those_of_one(mine: str, tmp_path: Path) -> None:
    kind = load("policies", f"{mine}:Says")
    for name, seed, policy in (("a", 0, f"{mine}:Says"), ("b", 1, kind), ("c", 0, "paper"), ("d", 1, "paper")):
        colonysim.run("sanity", policy=policy, seed=seed, episodes=1, out=tmp_path / name, decisions=False)
    found = compare([tmp_path / name for name in "abcd"], by="policy")
    assert {(each.reference, each.other, each.seeds) for each in found} == {("mine", "paper", 2)}


def test_tables_of_a_sweep_have_that_name_too(mine: str, tmp_path: Path) -> None:
    file = tmp_path / "sweep.yaml"
    file.write_text(f"scenarios: [sanity]\npolicies: ['{mine}:Says', paper]\nepisodes: 1\n")
    run_sweep(file, tmp_path / "out", workers=1)
    assert read_table(tmp_path / "out", "trials")["policy"].to_pylist() == ["mine", "paper"]
    colonysim.run("sanity", policy=load("policies", f"{mine}:Says"), episodes=1, out=tmp_path / "run")
    [found, *_] = compare([tmp_path / "run", tmp_path / "out"], by="policy")
    assert (found.reference, found.other) == ("mine", "paper")


def test_what_says_the_same_name_is_told_apart_and_what_is_listed_twice_is_one_trial(mine: str) -> None:
    def policies(*names: str) -> list[object]:
        return [t.described()["policy"] for t in plan_sweep({"scenarios": ["sanity"], "policies": [*names]}).trials]

    assert policies(f"{mine}:Says", f"{mine}:Also") == [f"{mine}:Says", f"{mine}:Also"]
    assert policies("stigmergy") == ["colony"] and policies("stigmergy", "colony") == ["stigmergy", "colony"]
    assert policies("colony", "colonysim.policies.presets:Colony") == ["colony"]
    worlds = ["nodeworld", "colonysim.backends.nodeworld:NodeWorld", f"{mine}:World"]
    plan = plan_sweep({"scenarios": ["sanity"], "backends": worlds})
    assert [trial.described()["backend"] for trial in plan.trials] == ["nodeworld", "my-world"]
    with pytest.raises(ColonysimError, match=r"backends\.1: no backend 'nodewrld'; did you mean 'nodeworld'"):
        plan_sweep({"scenarios": ["sanity"], "backends": ["nodeworld", "nodewrld"]})
