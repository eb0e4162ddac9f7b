"""Runs of somebody else: opening them runs nothing of theirs, and their names do not command a terminal."""

from __future__ import annotations

import ast
import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from recorded_runs import manifest, record, rows
from typer.testing import CliRunner, Result

import colonysim
import colonysim.cli
from colonysim.characters import visible
from colonysim.cli import app
from colonysim.cli.console import print_json, print_table, say
from colonysim.trace.reader import Run

NASTY = "a\x1b]0;owned\x07\x1b[2J\x9b31m\u202e[red]b[/red]:warning:\r$\\frac{$"
READERS = (
    ("report", "DIR"), ("report", "DIR", "--json"), ("export", "DIR"), ("export", "DIR", "frames", "-f", "json"),
    ("export", "DIR", "-o", "t.parquet"), ("compare", "DIR", "OTHER", "--by", "source"), ("results", "DIR"),
    ("plot", "DIR", "-o", "plots"), ("view", "DIR", "--no-open", "-o", "v.html"),
    ("video", "DIR", "v.gif", "--seconds", "0.2", "--size", "160x160", "--overwrite"), ("verify", "DIR"),
)  # fmt: skip


@pytest.fixture
def planted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A module `evil` where Python finds it, that leaves a mark when it is imported."""
    (tmp_path / "evil.py").write_text(
        "from pathlib import Path\nPath(__file__).with_name('ran').write_text('')\n"
        "class P:\n    name = 'evil'\n    def __init__(self, *_):\n        raise SystemExit(77)\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.chdir(tmp_path)
    yield tmp_path
    assert "evil" not in sys.modules and not (tmp_path / "ran").exists()


def _plant(path: Path) -> None:
    """Names the module wherever a run names anything."""
    file = path / "manifest.json"
    told = json.loads(file.read_text())
    told["scenario"]["policy"] = {"name": "evil:P", "extra_fields": ["evil:P"]}
    told |= {"policy": "evil:P", "backend": "evil:P", "plugins": {"evil:P": "evil"}, "versions": {"evil": "1"}}
    told["options"] |= {"backend": {"push": "evil:P"}, "overrides": ["policy=evil:P"], "initial": "evil:P"}
    told["fields"] |= {"evil:P": {"by_box": True, "class": "evil:P"}}
    file.write_text(json.dumps(told))


def _swept(path: Path) -> None:
    path.mkdir()
    about: dict[str, list[Any]] = {"trial": ["t0", "t1"], "policy": ["evil:P", "colony"], "backend": ["evil:P"] * 2,
                                   "policy.extra_fields": ['["evil:P"]'] * 2, "seed": [0, 0]}  # fmt: skip
    rest = {"status": ["succeeded"] * 2, "error": [None] * 2, "episodes": [1] * 2,
            "success": [1.0] * 2, "steps": [3.0] * 2}  # fmt: skip
    pq.write_table(pa.table(about | rest), path / "trials.parquet")
    played = {"episode": [1] * 2, "steps": [3] * 2, "success": [1.0] * 2, "ended": ["goal"] * 2,
              "sim_seconds": [2.5] * 2}  # fmt: skip
    pq.write_table(pa.table(about | played), path / "episodes.parquet")


def told(words: tuple[str, ...], directory: object, other: object = "") -> Result:
    return CliRunner().invoke(app, [w.replace("DIR", str(directory)).replace("OTHER", str(other)) for w in words])


@pytest.mark.parametrize("preset", ["evil:P", "colony"])
def test_no_reader_imports_a_module_that_data_name(planted: Path, preset: str) -> None:
    colonysim.run("sanity", episodes=2, seed=1, out="run")
    colonysim.run("sanity", episodes=2, seed=1, out="other")
    _plant(Path("run"))
    if preset != "evil:P":  # a policy of ours that carries a field of others
        file = Path("run/manifest.json")
        file.write_text(json.dumps(json.loads(file.read_text()) | {"policy": preset}))
    _swept(Path("sweep"))
    for words in READERS:
        result = told(words, "run", "other")
        refused = words[0] in ("results", "verify")  # no sweep; another scenario than the hash says
        assert result.exit_code == (2 if refused else 0), (words, result.output, result.exception)
    for words in (("results", "DIR"), ("results", "DIR", "--by", "policy"), ("compare", "DIR", "--by", "policy")):
        assert told(words, "sweep").exit_code == 0, told(words, "sweep").output
    run = Run.open("run")
    run.check_places()
    assert run.scenario.policy == "evil:P" and list(run.events()) and run.field("D") and not run.verify()


def test_not_even_in_the_folder_that_python_looks_in_first(planted: Path) -> None:
    colonysim.run("sanity", episodes=1, out="run")
    _plant(Path("run"))
    for words in (("view", "run", "--no-open"), ("report", "run"), ("plot", "run", "-w", "D,map")):
        done = subprocess.run([sys.executable, "-m", "colonysim", *words], capture_output=True, text=True, cwd=planted)
        assert done.returncode == 0, done.stderr


def test_names_do_not_command_the_terminal_and_are_no_markup(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    colonysim.run("sanity", episodes=2, seed=1, out="other")
    colonysim.run("sanity", episodes=2, seed=1, out="run")
    file = Path("run/manifest.json")
    about = json.loads(file.read_text()) | dict.fromkeys(("name", "variant", "backend", "policy", "mode"), NASTY)
    file.write_text(json.dumps(about))
    os.rename("run", f"run {NASTY[:20]}")  # noqa: PTH104
    for words in READERS:
        result = told(words, f"run {NASTY[:20]}", "other")
        assert not re.search("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202e]", result.output), (words, result.output)
        assert result.exit_code == (2 if words[0] == "results" else 0), (words, result.output, result.exception)
    assert json.loads(told(READERS[1], f"run {NASTY[:20]}").stdout)["policy"] == NASTY
    assert "[red]b[/red]:warning:" in told(("report", "DIR"), f"run {NASTY[:20]}").stdout


def test_words_are_written_out_and_lines_of_a_table_stay_lines(capsys: pytest.CaptureFixture[str]) -> None:
    assert visible("a\x1b[0m\u202eb\ud800\tc\n") == "a\\x1b[0m\\u202eb\\ud800\tc\n"
    say(NASTY)
    print_table(["a\x1b", "b"], [["[red]x[/red]", "one\ntwo"]], "[bold]\x07t")
    print_json({"a\x1b": "\u202e\x9b"})
    out, err = capsys.readouterr()
    assert "\x1b" not in out + err and "one\\ntwo" in out and "[red]x[/red]" in out and "[bold]\\x07t" in out
    assert json.loads(out[out.index("{") :]) == {"a\x1b": "\u202e\x9b"}


def test_every_command_prints_through_one_place() -> None:
    folder = Path(colonysim.cli.__file__).parent
    for file in folder.glob("*.py"):
        if file.name == "console.py":
            continue
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.Call):
                name = ast.unparse(node.func)
                assert name not in ("typer.echo", "print", "sys.stdout.write", "click.echo"), (file.name, name)


def test_a_run_that_is_not_finished_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    colonysim.run("sanity", episodes=2, seed=1, out="run")
    file = Path("run/manifest.json")
    about = json.loads(file.read_text())
    for changes, said in (
        ({"status": "interrupted", "episodes": 30}, "interrupted after 2 of 30 episodes"),
        ({"status": "failed", "episodes": 30}, "failed after 2 of 30 episodes"),
        ({"status": "running", "rows": {}, "trace_sha256": None}, "running or killed after 2 of 2 episodes"),
    ):
        file.write_text(json.dumps(about | changes))
        for words in READERS:
            slow = words[0] in ("plot", "video") and changes["status"] != "interrupted"  # the first time is enough
            if words[0] not in ("results", "verify") and not slow:
                result = told(words, "run", "run")
                assert f"run: {said}\n" in result.stderr, (words, result.output)


def test_verify_counts_and_says_what_differs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("good", "gone", "other", "scenario"):
        colonysim.run("sanity", episodes=2, seed=1, out=name)
    record(tmp_path / "open", rows()).flush()
    (tmp_path / "gone/deposits/part-00000.parquet").unlink()
    part = tmp_path / "other/frames/part-00000.parquet"
    table = pq.read_table(part)
    pq.write_table(table.take([*range(1, table.num_rows), 0]), part)
    file = tmp_path / "scenario/manifest.json"
    file.write_text(file.read_text().replace('"max_steps": ', '"max_steps": 1'))
    assert told(("verify", "good", "good"), "").exit_code == 0
    result = told(("verify", "good", "gone", "other", "scenario", "open", "nowhere"), "")
    assert result.exit_code == 2 and result.stdout.count("\n") == 1 and result.stdout.startswith("good: ok: ")
    for said in (
        r"gone/deposits: holds 0 rows, the manifest counts \d+", r"other: the rows or the scenario",
        r"scenario: the rows or", r"open: the run was not finished", r"nowhere: no such run",
    ):  # fmt: skip
        assert re.search(f"Error: .*{said}", result.stderr), (said, result.stderr)
    assert result.stderr.count("Error:") == 5


def test_a_bare_manifest_is_what_the_tests_think_it_is(tmp_path: Path) -> None:
    record(tmp_path / "run", rows()).finish("finished")
    assert Run.open(tmp_path / "run").manifest["name"] == manifest()["name"]
