"""Names, reasons and paths of others are shown, and never obeyed by the terminal."""

from __future__ import annotations

import json
import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

import colonysim
from colonysim.backends.mock import Mock
from colonysim.characters import visible
from colonysim.cli import app
from colonysim.world.intents import Outcome

EVIL = "\x1b[2J\x1b]0;mine\x07\r\x9b1m\u202e[/red]:bug:\x7f"
SCENARIO = """\
name: two
nodes: [[0, 0, 0, 1], [1, 1.5, 0, 1]]
edges: {radius: 1.6}
agents: [0]
goal: 1
"""


@pytest.fixture
def scenario(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "evil.yaml"
    file.write_text(SCENARIO)
    return file


def drained(terminal: int) -> str:
    """All that is written to a terminal until its other end is closed."""
    said = b""
    while True:
        try:
            said += os.read(terminal, 4096)
        except OSError:  # Linux says so when the other end is closed
            os.close(terminal)
            return said.decode()


def harmless(text: str) -> bool:
    return all(sign.isprintable() or sign == "\n" for sign in text)


def test_every_control_character_is_written_out_and_nothing_else() -> None:
    every = "".join(map(chr, range(0x110000)))
    shown = visible(every)
    assert visible(shown) == shown and shown.encode()
    assert not any(ord(sign) < 32 or 127 <= ord(sign) < 160 for sign in shown if sign not in "\n\t")
    assert visible("Zürich → ±, 日本, 👩‍🔬\n\tx") == "Zürich → ±, 日本, 👩‍🔬\n\tx"
    assert visible("a\x1bb\x9bc\udcff\u202e") == r"a\x1bb\x9bc\udcff\u202e"


def test_a_name_is_harmless_wherever_it_is_printed(scenario: Path) -> None:
    named = scenario.with_name("named.yaml")
    named.write_text(SCENARIO.replace("two", json.dumps(EVIL)))
    out = f"r{EVIL[:9].replace('/', '')}"
    colonysim.run(scenario, episodes=1, out=out)
    # A scenario of such a name is refused, but somebody else's run may hold one.
    manifest = json.loads(Path(out, "manifest.json").read_text())
    Path(out, "manifest.json").write_text(json.dumps(manifest | {"name": EVIL, "policy": EVIL, "backend": EVIL}))
    for words in (
        ["run", named, "-n", 1], ["validate", named], ["verify", out], ["report", out], ["report", out, "--json"],
        ["view", out, "--no-open"], ["compare", out, out], ["validate", scenario, EVIL],
        ["run", EVIL], ["report", EVIL], ["run", "easy", "--policy", EVIL], ["run", "easy", "--set", f"{EVIL}=1"],
        ["export", out, EVIL], ["run", "easy", "--variant", EVIL], ["new", "grid", "-o", out],
    ):  # fmt: skip
        result = CliRunner().invoke(app, [str(word) for word in words])
        assert harmless(result.output), (words, result.output)
        assert result.exit_code in (0, 2) and not isinstance(result.exception, ValueError)
    compared = CliRunner().invoke(app, ["compare", out, out, "--by", "policy", "--json"])
    assert harmless(compared.output)


def test_a_backends_reason_is_harmless_in_a_table_and_exact_in_a_pipe(scenario: Path) -> None:
    body = Mock(script=[Outcome("failed", 0, reason=EVIL)])
    colonysim.run(scenario, backend=body, episodes=1, out="run")
    table = CliRunner().invoke(app, ["report", "run"])
    assert table.exit_code == 0 and harmless(table.stdout) and r"\x1b[2J" in table.stdout
    exact = json.loads(CliRunner().invoke(app, ["export", "run", "-f", "json"]).stdout)
    assert EVIL in [row["reason"] for row in exact]
    here, there = pty.openpty()
    with subprocess.Popen([sys.executable, "-m", "colonysim", "export", "run"], stdout=there) as shown:
        os.close(there)
        assert harmless(drained(here).replace("\r\n", "\n"))
    assert shown.returncode == 0


def test_a_bars_title_and_lines_are_no_markup(scenario: Path) -> None:
    program = f"""
from colonysim import progress
progress.PATIENCE = progress._PAUSE = 0.0
with progress.Bar({EVIL!r}, 2) as bar:
    bar.move(1)
    bar.line({EVIL!r})
"""
    here, there = pty.openpty()
    environment = os.environ | {"TERM": "xterm", "COLUMNS": "200", "LINES": "30"}
    with subprocess.Popen([sys.executable, "-c", program], stderr=there, env=environment) as shown:
        os.close(there)
        said = drained(here)
    assert shown.returncode == 0, said
    assert visible(EVIL) in said and EVIL[:8] not in said and said.count("[/red]:bug:") >= 2
