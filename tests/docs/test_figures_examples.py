"""The commands that docs/sweeps.md and docs/runs.md mark as examples of figures and of CSV run as they stand."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

from colonysim.cli import app

pytest.importorskip("matplotlib")
DOCS = Path(__file__).parents[2] / "docs"


def run(page: str, mark: str) -> list[str]:
    """Runs the commands of the block below a mark, and returns what each printed."""
    [block] = re.findall(rf"<!-- {mark} -->\n```sh\n(.*?)```", (DOCS / page).read_text(encoding="utf-8"), re.DOTALL)
    printed = []
    for line in block.splitlines():
        words = shlex.split(line, comments=True)
        assert words[0] == "colonysim"
        done = CliRunner().invoke(app, words[1:])
        assert done.exit_code == 0, (line, done.output)
        printed.append(done.stdout)
    return printed


def test_those_of_sweeps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("beta.yaml").write_text(
        "scenarios: [sanity]\npolicies: [paper, colony]\n"
        "grid: {policy.beta: [1, 2], policy.epsilon: [0.2, 0.6]}\nseeds: {count: 2}\nepisodes: 2\n"
    )
    assert CliRunner().invoke(app, ["sweep", "beta.yaml", "--out", "results/beta", "--workers", "1"]).exit_code == 0
    every, means, heatmap, print_ = run("sweeps.md", "figures")
    names = ["means", "heatmap", "curves", "differences"]
    assert [Path(line).stem for line in every.splitlines()] == names
    assert [Path(each.strip()).name for each in (means, heatmap)] == ["means.png", "heatmap.svg"]
    assert [Path(line).name for line in print_.splitlines()] == [f"{name}.pdf" for name in names]
    assert all(Path(line).is_file() for line in (every + means + heatmap + print_).splitlines())
    _, of_query = run("sweeps.md", "csv")
    assert Path("beta.csv").read_text().startswith("policy,policy.beta,policy.epsilon,trials,")
    assert len(Path("beta.csv").read_text().splitlines()) == 9
    assert len(of_query.splitlines()) == 3


def test_those_of_several_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    *_, curves, all_of_them = run("runs.md", "several")
    assert [Path(line).stem for line in curves.splitlines()] == ["curves"]
    assert [Path(line).stem for line in all_of_them.splitlines()] == ["means", "curves", "differences"]
