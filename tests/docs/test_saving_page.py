"""The examples in docs/saving.md run as they stand, one after the other, and its commands too."""

from __future__ import annotations

import re
import shlex
import sys
from pathlib import Path
from types import ModuleType

import pytest
from typer.testing import CliRunner

import colonysim
from colonysim.cli import app
from colonysim.simulation.saving import VERSION

PAGE = Path(__file__).parents[2] / "docs" / "saving.md"


def blocks(kind: str) -> list[str]:
    return re.findall(rf"```{kind}\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


def test_the_examples_run(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    names: dict[str, object] = {"directory": tmp_path}
    for code in blocks("python"):
        exec(compile(code, str(PAGE), "exec"), names)
    futures, text = capsys.readouterr().out.splitlines()
    assert re.fullmatch(r"\d+ s, with beta 1 from then on \d+ s", futures)
    assert text.startswith(f"colonysim colony {VERSION} ")
    module = ModuleType("alarms")
    module.Alarm = names["Alarm"]  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "alarms", module)
    settings = {"policy.extra_fields": ["alarms:Alarm"], "policy.weights.A": -1.0}
    scenario = colonysim.load_scenario("hard", None, settings)
    colony = colonysim.Colony(scenario, seed=1)
    colony.run_until(time=20.0)
    assert colony.fields["A"].values().sum() > 0
    colony.save(tmp_path / "alarmed.npz")
    rest = list(colony)
    assert list(colonysim.Colony.load(tmp_path / "alarmed.npz", scenario=scenario)) == rest
    with pytest.raises(colonysim.ColonysimError, match=r"names code of others.*alarms:Alarm; give scenario="):
        colonysim.Colony.load(tmp_path / "alarmed.npz")


def test_the_commands_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for line in "".join(blocks("sh")).splitlines():
        words = shlex.split(line.replace("1000", "3").replace("0-19", "0-3"))
        assert words[0] == "colonysim"
        done = CliRunner().invoke(app, words[1:])
        assert done.exit_code == 0, (line, done.output)
    assert "policy.beta" in done.output


def test_what_the_page_lists_is_in_the_file(tmp_path: Path) -> None:
    import json

    import numpy

    colony = colonysim.Colony("sanity", seed=1)
    colony.step()
    colony.save(tmp_path / "colony.npz")
    with numpy.load(tmp_path / "colony.npz", allow_pickle=False) as archive:
        text = json.loads(archive["colony.json"])
    page = PAGE.read_text(encoding="utf-8").split("## The file")[1].split("## Parts")[0]
    told = set(re.findall(r"`([a-z_0-9]+)`", page))
    assert set(text) | set(text["state"]) <= told | {"course"}
