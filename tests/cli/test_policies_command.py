"""`colonysim policies`, and the parameters of policies in the JSON Schema of scenario files."""

from __future__ import annotations

import json
import sys
from importlib.metadata import EntryPoint, EntryPoints
from pathlib import Path

import pytest
from typer.testing import CliRunner

from colonysim import plugins
from colonysim.cli import app
from colonysim.plugins import BUILT_IN
from colonysim.policies.described import describe
from colonysim.policies.schema import scenario_schema
from colonysim.policies.settings import PRESETS, StigmergySettings
from colonysim.scenario.loading import list_scenarios
from colonysim.scenario.source import read_text

OF_OTHERS = '''
import dataclasses
import pydantic
from colonysim.policies.presets import Paper

class Calm(pydantic.BaseModel):
    rest: float = pydantic.Field(
        2.5, ge=0, lt=10, description="Seconds | of rest.", json_schema_extra={"paper": "Alg. 9"}
    )
    names: list[str]

class Declares:
    """Says what it takes."""
    parameters = Calm

class Derived(Paper):
    pass

class Silent:
    pass

@dataclasses.dataclass
class Plain:
    x: int = 0

class Wrong:
    parameters = Plain
'''


def told(*words: str) -> str:
    answer = CliRunner().invoke(app, ["policies", *words])
    assert answer.exit_code == 0, answer.stderr
    return answer.stdout


@pytest.fixture
def others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    (tmp_path / "policies_of_others.py").write_text(OF_OTHERS)
    monkeypatch.syspath_prepend(str(tmp_path))
    point = EntryPoint("calm", "policies_of_others:Declares", "colonysim.policies")
    monkeypatch.setattr(plugins, "entry_points", lambda group: EntryPoints([point]).select(group=group))
    sys.modules.pop("policies_of_others", None)
    return "policies_of_others"


def test_parameters_have_the_defaults_of_the_preset():
    for name in ("stigmergy", *PRESETS):
        found = json.loads(told(name, "--json"))
        wanted = StigmergySettings(**PRESETS.get(name, {}))
        defaults = {each["name"]: each["default"] for each in found["parameters"]}
        assert defaults.pop("preset", None) == ("colony" if name == "stigmergy" else None)
        for parameter, default in defaults.items():
            value = getattr(wanted, parameter)
            assert (list(value) if isinstance(value, tuple) else value) == default
    beta = next(each for each in found["parameters"] if each["name"] == "beta")
    assert beta["schema"] == {"type": "number", "minimum": 0.0, "maximum": 1e9} and beta["paper"] == "Alg. 9"


def test_the_table_of_one_policy():
    lines = told("paper").splitlines()
    assert lines[0].startswith("paper (colonysim.policies.presets:Paper): ")
    row = next(line for line in lines if line.startswith(" patience"))
    assert row.split()[:7] == ["patience", "number", "or", "null", "0.001", "to", "1e+09"] and " null   " in row
    assert '"reservation" or "two_node"' in told("colony")
    assert told("random").endswith("It has no parameters.\n")
    answer = CliRunner().invoke(app, ["policies", "papr"])
    assert answer.exit_code == 2 and answer.stderr == "Error: no policy 'papr'; did you mean 'paper'?\n"
    assert CliRunner().invoke(app, ["policies", "--json", "--markdown"]).exit_code == 2


def test_the_list_imports_nothing_of_others(others):
    listed = told()
    assert "installed as policies_of_others:Declares, not imported: `colonysim policies calm` does" in listed
    found = {each["name"]: each for each in json.loads(told("--json"))}
    assert [*found] == [*BUILT_IN["policies"], "calm"] and found["random"]["parameters"] == []
    assert found["calm"]["parameters"] is None and not found["calm"]["imported"]
    assert others not in sys.modules


def test_policies_of_others_say_what_they_declare(others):
    rest, names = json.loads(told("calm", "--json"))["parameters"]
    assert rest["schema"] == {"type": "number", "minimum": 0, "exclusiveMaximum": 10}
    assert (rest["default"], rest["meaning"], rest["paper"]) == (2.5, "Seconds | of rest.", "Alg. 9")
    assert names["required"] and names["type"] == "list of texts"
    table = told(f"{others}:Declares", "--markdown")
    assert "| `rest` | number, at least 0, below 10 | 2.5 | Alg. 9 | Seconds \\| of rest. |\n" in table
    assert "| `names` | list of texts | required |  |  |\n" in table
    assert describe(f"{others}:Derived").parameters == describe("paper").parameters
    assert "does not say which parameters it has" in told(f"{others}:Silent")
    answer = CliRunner().invoke(app, ["policies", f"{others}:Wrong"])
    assert answer.exit_code == 2 and "expected a class that is a pydantic model or dataclass" in answer.stderr


@pytest.fixture(scope="module")
def faults_of():
    jsonschema = pytest.importorskip("jsonschema")
    validator = jsonschema.Draft202012Validator(scenario_schema())
    validator.check_schema(scenario_schema())

    def faults(policy: object = None, **more: object) -> list[str]:
        place = {"nodes": [[0, 0, 0], [1, 1, 0]], "edges": [[0, 1]], "goal": 1}
        document = {**place, **({} if policy is None else {"policy": policy}), **({"agents": [0]} | more)}
        if "groups" in document:
            del document["agents"]
        return [f"{error.json_path}: {error.message}" for error in validator.iter_errors(document)]

    return faults


@pytest.mark.parametrize("policy", [
    "paper", "mine:Policy", {"beta": 2}, {"name": "paper", "preset": "colony", "box_cap": None, "tries": 3},
    {"name": "mine:Policy", "betta": "hot"}, {"name": "random"}, {"preset": "oracle", "weights": {"A": -1.5}},
])  # fmt: skip
def test_policies_that_the_schema_takes(faults_of, policy):
    assert faults_of(policy) == []
    assert faults_of(variants={"other": {"policy": policy}}) == []
    assert faults_of(groups=[{"name": "few", "agents": [0], "policy": policy}]) == []


@pytest.mark.parametrize("policy", [
    {"name": "stigmergy", "betta": 2}, {"name": "colony", "beta": -1}, {"name": "paper", "collision": "none"},
    {"name": "random", "beta": 2}, {"name": "oracle", "tries": 0}, {"name": "stigmergy", "preset": "papr"},
])  # fmt: skip
def test_policies_that_the_schema_refuses(faults_of, policy):
    assert faults_of(policy)
    assert faults_of(variants={"other": {"policy": policy}})
    assert faults_of(groups=[{"name": "few", "agents": [0], "policy": policy}])


def test_a_policy_without_a_name_is_the_stigmergic_one_unless_it_changes_another(faults_of):
    assert faults_of({"betta": 2})
    assert faults_of(variants={"other": {"policy": {"rest": 2}}}, policy={"name": "mine:Policy"}) == []
    assert faults_of(groups=[{"name": "few", "agents": [0], "policy": {"rest": 2}}]) == []
    hints = scenario_schema()["$defs"]["VariantPolicy"]["else"]["properties"]
    assert hints["beta"]["description"].startswith("Factor of the values in every softmax")


def test_the_shipped_scenarios_are_valid_by_the_schema():
    jsonschema = pytest.importorskip("jsonschema")
    for _, path, _, _ in list_scenarios():
        jsonschema.validate(read_text(path.read_text(encoding="utf-8"), path.name)[0], scenario_schema())


def test_the_schema_explains_parameters_with_defaults_of_each_preset():
    sections = scenario_schema()["$defs"]
    assert sections["StigmergyPolicy"]["properties"]["beta"]["default"] == 4.0
    assert "(Alg. 9 of the paper) Preset paper: 1." in sections["StigmergyPolicy"]["properties"]["beta"]["description"]
    assert sections["PaperPolicy"]["properties"]["beta"]["default"] == 1.0
    assert sections["OraclePolicy"]["properties"]["updates"]["default"] == "everywhere"
