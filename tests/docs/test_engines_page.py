"""The example in docs/engines.md runs as it stands."""

import re
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "engines.md"


def test_the_scene_of_the_page_goes_on_from_its_saved_state(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("mujoco")
    [code] = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    exec(compile(code, str(PAGE), "exec"), {})
    assert re.fullmatch(r"the box has come to x = 1\.\d\d m\n", capsys.readouterr().out)
