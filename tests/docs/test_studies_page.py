"""The study in docs/studies.md runs as it stands."""

import re
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "studies.md"


def test_the_study_of_the_trail_runs_and_says_what_the_page_says(capsys: pytest.CaptureFixture[str]) -> None:
    names: dict[str, object] = {}
    for code in re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL):
        exec(compile(code, str(PAGE), "exec"), names)
    without, fading = eval(capsys.readouterr().out, {})
    assert without is None
    assert 0 < fading < 1200
    adapts = names["adapts"]
    assert all(adapts(60.0, 0.0, seed) is not None for seed in (2, 3, 4))  # type: ignore[operator]
    assert all(adapts(None, 0.0, seed) is None for seed in (2, 3))  # type: ignore[operator]
