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
    forgetting, crowds, lessons = names["forgetting"], names["crowds"], names["lessons"]
    # What the text makes of the figures.
    assert forgetting[None][8] > 1.7 * forgetting[None][7]
    assert forgetting[30][8] < forgetting[30][7]
    rates = [rate for _, _, rate in crowds.values()]
    assert rates == sorted(rates) and rates[2] > 1.9 * rates[0] and rates[5] < 1.2 * rates[4]
    reached = {name: sum(share for _, share in found) / len(found) for name, found in lessons.items()}
    assert reached["nothing"] == reached["beta 12"] == 1.0 and reached["beta 0"] < 0.5 < reached["beta 0.5"] < 0.9
    assert reached["agent 0 fails"] < 0.1 and 0.4 < reached["agent 3 fails"] < 0.75
