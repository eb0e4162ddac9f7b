"""The examples in docs/learning.md run as they stand, one after the other, and its tables list what there is."""

from __future__ import annotations

import re
from importlib.util import find_spec
from pathlib import Path

import pytest

pytest.importorskip("pettingzoo")

PAGE = Path(__file__).parents[2] / "docs" / "learning.md"
TEXT = PAGE.read_text(encoding="utf-8")


@pytest.mark.usefixtures("engine")
def test_the_examples_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    names: dict[str, object] = {"folder": tmp_path}
    expected = [
        r"\d+\.\d s, -\d+\.\d", r"\(422, 480, 3\) uint8", r"True (\d{3,}|[6-9]\d)", r"\d{3,}|[6-9]\d", "True",
        {"torchrl": r"torch\.Size\(\[200\]\) True"}, r"\(9,\) \(360, 360, 3\) \d+",
        r"Box\(-8\.0, 8\.0, \(2,\), float32\) 12", {"stable_baselines3": "60"},
    ]  # fmt: skip
    """What is printed, one after the other; in braces by which package, if it is installed."""
    missing = set()
    for code in re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL):
        needed = re.match(r"# needs (\w+)", code)
        if needed and find_spec(needed[1]) is None:
            missing.add(needed[1])
            continue
        exec(compile(code, str(PAGE), "exec"), names)
    patterns = list[str]()
    for each in expected:
        patterns += [each] if isinstance(each, str) else [words for name, words in each.items() if name not in missing]
    said = capsys.readouterr().out.splitlines()
    for line, pattern in zip(said, patterns, strict=True):
        assert re.fullmatch(pattern, line), (line, pattern)


def test_the_tables_list_what_there_is() -> None:
    from colonysim import rl
    from colonysim.rl.moves import PARTS
    from colonysim.rl.options import Options

    def first_column(heading: str) -> list[str]:
        section = re.split(r"^#+ .*$", TEXT.split(heading)[1], maxsplit=1, flags=re.MULTILINE)[0]
        cells = re.findall(r"^\| (`.*?) \|", section, re.MULTILINE)
        return [name for cell in cells for name in re.findall(r"`(\w+)`", cell)]

    assert first_column("Options, the same") == [*dict.fromkeys(first_column("Options, the same"))]
    assert set(first_column("Options, the same")) == set(Options.__annotations__)
    assert first_column("### What an agent is told") == [*PARTS, "action_mask"]
    assert first_column("### What it is paid") == [*rl.REWARDS]
