from __future__ import annotations

import csv
import importlib.util
import io
import json
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from colonysim.cli import app
from colonysim.installing import install_command
from colonysim.trace.reader import Run


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def colonysim(*words: object) -> Result:
    return CliRunner().invoke(app, [str(word) for word in words])


def test_a_run_is_recorded_and_printed() -> None:
    result = colonysim("run", "sanity", "-n", 2, "--seed", 5)
    assert result.exit_code == 0, result.output
    assert "runs/sanity-nodeworld-s5-1" in result.stdout
    assert "episode   2:" in result.stderr and "episode   2:" not in result.stdout
    run = Run.open("runs/sanity-nodeworld-s5-1")
    assert run.status == "finished" and len(run.episodes) == 2
    assert run.trace_sha256 is not None and run.trace_sha256 in result.stdout
    assert run.scenario.digest == run.manifest["scenario_sha256"]


def test_json_is_one_object_with_exactly_these_fields() -> None:
    result = colonysim("run", "sanity", "-n", 3, "--json", "--out", "here")
    found = json.loads(result.stdout)
    assert list(found) == [
        "scenario", "backend", "policy", "mode", "seed", "out", "trace_sha256", "episodes", "summary",
    ]  # fmt: skip
    assert found["out"] == "here" and found["mode"] == "asynchronous" and found["backend"] == "nodeworld"
    assert [set(e) for e in found["episodes"]] == [
        {"episode", "steps", "success", "ended", "sim_seconds", "wall_seconds"}
    ] * 3
    assert list(found["summary"]) == ["steps_mean", "steps_sd", "success_mean", "success_sd"]
    assert found["summary"]["steps_mean"] == sum(e["steps"] for e in found["episodes"]) / 3


def test_the_same_seed_has_the_same_hash_with_and_without_a_trace() -> None:
    def digest(*words: object) -> str:
        return str(json.loads(colonysim("run", "easy", "-n", 2, "--json", "-q", *words).stdout)["trace_sha256"])

    first = digest("--seed", 1)
    assert digest("--seed", 1, "--no-trace") == first
    assert digest("--seed", 2, "--no-trace") != first
    assert digest("--seed", 1, "--no-trace", "--no-decisions") != first
    assert len(list(Path("runs").iterdir())) == 1


def test_options_reach_the_run() -> None:
    words = ["--variant", "r5-6", "--policy", "paper", "--mode", "synchronous", "--set", "max_steps=5"]
    result = colonysim("run", "hard", "-n", 1, *words)
    assert result.exit_code == 0, result.output
    run = Run.open("runs/hard-r5-6-nodeworld-s0-1")
    assert len(run.scenario.agents) == 6 and run.scenario.max_steps == 5
    assert (run.manifest["policy"], run.manifest["mode"]) == ("paper", "synchronous")
    assert run.episodes[0].steps == 5


def test_a_run_can_start_from_another_ones_pheromones() -> None:
    colonysim("run", "sanity", "-n", 2, "--out", "first")
    result = colonysim("run", "sanity", "-n", 1, "--from", "first", "--out", "second")
    assert result.exit_code == 0, result.output
    assert Run.open("second").manifest["options"]["initial"] == str(Path("first").absolute())
    colonysim("run", "sanity", "-n", 1, "--out", "fresh")
    assert Run.open("second").field("D") != Run.open("fresh").field("D")


def test_a_run_without_pheromones_is_no_start() -> None:
    colonysim("run", "sanity", "-n", 1, "--policy", "random", "--out", "markless")
    result = colonysim("run", "sanity", "-n", 1, "--from", "markless", "--out", "second")
    assert result.exit_code == 2 and "markless: this run left no pheromones" in result.stderr
    assert not Path("second").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("run", "hrad"), "did you mean 'hard'?"),
        (("rnu", "hard"), "'run'"),
        (("run", "hard", "--backend", "bulet"), "did you mean 'bullet'?"),
        (("run", "hard", "--policy", "colny"), "did you mean 'colony'?"),
        (("run", "hard", "--set", "policy.bata=2"), "did you mean 'beta'?"),
        (("run", "hard", "--variant", "r5"), "no variant 'r5'"),
        (("run", "hard", "--mode", "sync"), "'synchronous'"),
        (("run", "hard", "--push", "rl"), "--backend physics"),
        (("run", "hard", "--episodes", "0"), "--episodes"),
        (("run", "hard", "--from", "nowhere"), "no such run directory"),
        (("run", "hard", "--out", "."), "not empty"),
        (("validate", "nowhere.yaml"), "no such file"),
        (("export", "nowhere"), "no such run directory"),
        (("scenarios", "hrad"), "did you mean 'hard'?"),
        (("plot", "nowhere"), "no such run directory"),
    ],
)
def test_mistakes_are_told_on_standard_error_with_exit_code_2(words: tuple[str, ...], said: str) -> None:
    Path("in-the-way").write_text("")
    result = colonysim(*words)
    assert result.exit_code == 2
    assert said in result.stderr and not result.stdout
    assert "Traceback" not in result.output
    assert not Path("runs").exists()


def test_validate_names_file_line_and_column() -> None:
    assert colonysim("validate", "sanity", "easy", "medium", "hard").exit_code == 0
    text = colonysim("scenarios", "sanity").stdout
    Path("mine.yaml").write_text(text.replace("goal: 8", "goal: 88"))
    result = colonysim("validate", "mine.yaml", "sanity")
    assert result.exit_code == 2
    line = next(n for n, row in enumerate(text.splitlines(), 1) if row.startswith("goal: 8"))
    assert f"mine.yaml:{line}:" in result.stderr
    assert "sanity: valid: 9 nodes, 13 edges, 2 holes, 2 boxes, 1 agent" in result.stdout


def test_lists() -> None:
    listed = json.loads(colonysim("scenarios", "--json").stdout)
    assert {"sanity", "easy", "medium", "hard"} <= {each["name"] for each in listed}
    found = {(e["kind"], e["name"]) for e in json.loads(colonysim("backends", "--json").stdout)}
    assert {("backends", name) for name in ("nodeworld", "bullet", "mujoco", "physics")} <= found
    assert {("policies", "paper"), ("fields", "D"), ("robots", "half")} <= found
    assert "hard" in colonysim("scenarios").stdout and "nodeworld" in colonysim("backends").stdout


def test_schemas_are_json() -> None:
    assert "agents" in json.loads(colonysim("schema").stdout)["properties"]
    assert "events" in json.loads(colonysim("schema", "trace").stdout)["tables"]


def test_tables_can_be_exported() -> None:
    import pyarrow.parquet as pq

    colonysim("run", "sanity", "-n", 3, "--out", "run")
    wanted = Run.open("run").table("decisions").num_rows
    rows = list(csv.DictReader(io.StringIO(colonysim("export", "run", "decisions").stdout)))
    assert len(rows) == wanted and " " in rows[0]["targets"] + rows[0]["probabilities"] + " "
    as_json = json.loads(colonysim("export", "run", "episodes", "--episodes", "1,3", "-f", "json").stdout)
    assert [row["episode"] for row in as_json] == [1, 3]
    assert colonysim("export", "run", "decisions", "-o", "d.parquet").exit_code == 0
    assert pq.read_table("d.parquet").num_rows == wanted
    assert colonysim("export", "run", "-o", "d.xyz").exit_code == 2
    assert colonysim("export", "run", "-f", "parquet").exit_code == 2
    assert colonysim("export", "run", "evnts").exit_code == 2
    assert colonysim("export", "run", "--episodes", "3-1").exit_code == 2


@pytest.mark.parametrize(
    "command",
    [
        "run hard --backend {}",
        "evaluate push --engine {}",
        "train push -o x --engine {}",
        "train feasibility -o x --engine {}",
        "train way -o x --engine {}",
    ],
)
@pytest.mark.parametrize("name", ["bullet", "mujoco"])
def test_an_engine_that_is_missing_is_named_with_the_command_that_installs_it(
    name: str, command: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    without(monkeypatch, "pybullet", "mujoco")
    result = colonysim(*command.format(name).split())
    assert result.exit_code == 2 and install_command(name) in result.stderr


def test_where_bullet_has_no_wheel_the_other_engine_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    without(monkeypatch, "pybullet")
    monkeypatch.setattr("colonysim.physics.engine._NO_BULLET", sys.version_info[:2])
    result = colonysim("run", "hard", "--backend", "bullet")
    assert result.exit_code == 2 and "no wheel for Python 3." in result.stderr
    assert f"'mujoco' runs here: {install_command('mujoco')}" in result.stderr


def test_backends_tells_versions_of_engines_and_what_is_missing(
    some_engine: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def listed() -> dict[str, dict[str, str]]:
        return {each["name"]: each for each in json.loads(colonysim("backends", "--json").stdout)}

    there = listed()
    assert there["nodeworld"]["version"] == "" and there[some_engine]["problem"] == ""
    assert there["physics"]["version"] == there[some_engine]["version"]
    assert any(char.isdigit() for char in there[some_engine]["version"])
    assert there[some_engine]["version"] in colonysim("backends").stdout
    without(monkeypatch, "pybullet", "mujoco")
    missing = listed()
    for name in ("bullet", "mujoco"):
        assert install_command(name) in missing[name]["problem"]
    assert missing["physics"]["problem"] == missing["bullet"]["problem"]


def without(monkeypatch: pytest.MonkeyPatch, *modules: str) -> None:
    """Lets modules look as if they were not installed."""
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *rest: None if name in modules else find(name, *rest))


CRASH = """\
import json
from colonysim.policies.presets import Colony

def helper(text):
    return json.loads(text)

class Asks(Colony):
    def decide(self, view, memory, random):
        return helper("{")

class Passes(Colony):
    def decide(self, view, memory, random):
        return super().decide(view, memory, None)

class Makes(Colony):
    def __init__(self, scenario):
        raise RuntimeError("no")

class Answers(Colony):
    def decide(self, view, memory, random):
        return 5
"""


@pytest.mark.parametrize(("name", "line"), [("Asks", 5), ("Passes", 13), ("Makes", 17), ("Answers", None)])
def test_an_error_in_code_of_others_is_told_with_file_and_line(
    name: str, line: int | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(tmp_path))
    Path(f"crashes_{name}.py").write_text(CRASH)
    result = colonysim("run", "sanity", "-q", "-p", f"crashes_{name}:{name}")
    assert result.exit_code == 2 and result.stderr.count("\n") == 1
    assert result.stderr.endswith(f" (crashes_{name}.py:{line})\n") is (line is not None), result.stderr


def test_a_module_that_cannot_be_read_is_told_with_file_and_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(tmp_path))
    Path("broken_here.py").write_text("x = 1\ny = = 2\n")
    Path("fails_here.py").write_text("\n\nx = 1 / 0\n")
    for module, line in (("broken_here", 2), ("fails_here", 3)):
        result = colonysim("run", "sanity", "-q", "-p", f"{module}:P")
        assert result.exit_code == 2 and f" ({module}.py:{line})\n" in result.stderr and result.stderr.count("\n") == 1
