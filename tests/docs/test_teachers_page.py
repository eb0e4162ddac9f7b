"""The solutions of the exercises run as they stand, and say what the page says of them."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from doc_pages import blocks, play


def test_the_solutions_run_and_say_what_the_page_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    names, printed = play("teachers", tmp_path)
    sys.modules.pop("loner", None)
    assert printed == "".join(block.code for block in blocks("teachers") if block.language == "text")
    forgetting, crowds = names["forgetting"], names["crowds"]
    # What the text makes of the figures.
    assert forgetting[None][8] > 1.7 * forgetting[None][7]
    assert forgetting[30][8] < forgetting[30][7]
    rates = [rate for _, _, rate in crowds.values()]
    assert rates == sorted(rates) and rates[2] > 1.9 * rates[0] and rates[5] < 1.2 * rates[4]
