"""The examples in docs/colony.md run as they stand, one after the other."""

import re
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "colony.md"


def test_the_examples_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    names: dict[str, object] = {"directory": tmp_path / "run"}
    for code in re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL):
        exec(compile(code, str(PAGE), "exec"), names)
    held, shown, changed, spread = capsys.readouterr().out.splitlines()
    assert held.startswith("12.0 [") and shown.startswith("<Colony hard: episode 3 of ")
    assert changed.startswith("{'policy': {'beta': 0.5}, 'episode': 1, 'time': 12.0") and changed.endswith(" {}")
    assert len(names["levels"]) > 30 and names["levels"][20].sum() > 0  # type: ignore[arg-type, index]
    assert re.fullmatch(r"\[\d+\.\d+, \d+\.\d+, \d+\.\d+\]", spread)


def test_what_the_page_lists_is_there() -> None:
    import colonysim

    colony = colonysim.Colony("hard", seed=1)
    page = PAGE.read_text(encoding="utf-8").split("## Looking")[1].split("## Watching")[0]
    for row in re.findall(r"^\| `(agents|boxes|world)` \| (.*) \|$", page, re.MULTILINE):
        part = getattr(colony, row[0])
        named = {name.split("(")[0] for name in re.findall(r"`([^`]+)`", row[1])}
        public = {name for name in dir(part) if not name.startswith("_")}
        assert named == public, row[0]
