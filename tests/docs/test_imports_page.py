"""The commands and the code in docs/imports.md run as they stand, and its tables are what the readers do."""

from __future__ import annotations

import re
import shlex
import shutil
from pathlib import Path

import pytest
from PIL import Image
from typer.testing import CliRunner

from colonysim.cli import app
from colonysim.scenario.imports import _ENDINGS, FORMATS
from colonysim.scenario.imports.movingai import FLOOR, read_movingai
from colonysim.scenario.imports.picture import LEGEND

PAGE = (Path(__file__).parents[2] / "docs" / "imports.md").read_text(encoding="utf-8")
MAPS = Path(__file__).parents[1] / "scenarios" / "maps"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for path in MAPS.iterdir():
        shutil.copy(path, tmp_path)
    picture = Image.new("RGB", (5, 4), "#c3bdc0")
    picture.putpixel((1, 1), (129, 64, 2))
    picture.save("plan.png")


def blocks(kind: str) -> list[str]:
    return re.findall(rf"```{kind}\n(.*?)```", PAGE, re.DOTALL)


def table(section: str) -> list[list[str]]:
    """The rows of the first table of a section, cell by cell."""
    text = PAGE.split(f"\n## {section}\n")[1].split("\n## ")[0]
    rows = [line.strip("| ").split(" | ") for line in text.splitlines() if line.startswith("|")]
    return rows[2:]


def test_the_commands_run() -> None:
    for line in "".join(blocks("sh")).splitlines():
        words = shlex.split(line)
        assert words[0] == "colonysim"
        done = CliRunner().invoke(app, words[1:])
        assert done.exit_code == 0, (line, done.output)


def test_the_code_runs(capsys: pytest.CaptureFixture[str]) -> None:
    for code in blocks("python"):
        exec(compile(code, "imports.md", "exec"), {})
    assert capsys.readouterr().out == "warehouse 106 1.0\n"


def test_the_endings_and_formats_are_those_that_are_read() -> None:
    rows = re.findall(r"^\| (`\..*?) \| \[`(\w+)`\]", PAGE, re.MULTILINE)
    told = {ending: name for endings, name in rows for ending in re.findall(r"`(\.\w+)`", endings)}
    assert told == _ENDINGS and set(told.values()) == set(FORMATS)


def test_the_tables_are_what_the_readers_do() -> None:
    assert {row[0].strip("`"): row[-1] for row in table("Pictures")} == LEGEND
    for characters, _, here in table("MovingAI"):
        for character in re.findall(r"`(.)`", characters):
            read = read_movingai(f"type octile\nheight 1\nwidth 1\nmap\n{character}\n".encode(), "x")
            assert bool(read.floor[0]) == here.startswith("floor") == (character in FLOOR)
