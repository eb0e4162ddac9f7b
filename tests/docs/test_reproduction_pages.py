"""docs/reproduction says what the stored results say."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import pytest

from colonysim.reproduce import reproduce

DOCS = Path(__file__).parents[2] / "docs"
PAGES, RESULTS = DOCS / "reproduction", DOCS / "results"
STORED = ("performance-physics", "push")
"""The studies that are made from stored results alone."""

pytest.importorskip("matplotlib")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    physics = [RESULTS / "bullet.jsonl", RESULTS / "mujoco.jsonl"]
    out = tmp_path_factory.mktemp("made")
    return reproduce(out, STORED, physics=physics, trainings=RESULTS / "push_ablation.jsonl").markdown.parent


def rows_of(folder: Path, *studies: str) -> list[list[str]]:
    """The rows of the page of verdicts, cell by cell; of some studies if they are named."""
    lines = (folder / "verdicts.md").read_text(encoding="utf-8").splitlines()
    rows = [line.strip("| ").split(" | ") for line in lines if line.startswith("| ")][2:]
    return [row for row in rows if not studies or row[1] in studies]


def test_the_tables_of_physics_and_of_the_push_are_those_of_the_stored_results(made):
    start = "## Performance in physics"
    page, again = ((folder / "performance.md").read_text(encoding="utf-8") for folder in (PAGES, made))
    assert page[page.index(start) :] == again[again.index(start) :]
    assert (PAGES / "push.md").read_text(encoding="utf-8") == (made / "push.md").read_text(encoding="utf-8")
    assert rows_of(PAGES, *STORED) == rows_of(made)


def test_the_first_page_counts_the_verdicts_and_names_each_that_is_undecided():
    rows, first = rows_of(PAGES), (PAGES / "index.md").read_text(encoding="utf-8")
    words = Counter(row[4] for row in rows)
    assert f"We set {len(rows)} figures and claims of the paper beside runs of our own: " in first
    assert (
        f"{words['agrees']} agree, in {words['better']} ours is better, {words['disagrees']} differ, "
        f"{words['undecided']} are undecided" in first
    )
    subjects = first.partition("## By subject\n\n")[2].partition("\n\n")[0].splitlines()[2:]
    counted = [[int(cell) for cell in line.strip("| ").split(" | ")[1:]] for line in subjects]
    assert [sum(column) for column in zip(*counted, strict=True)] == [
        len(rows), *(words[word] for word in ("agrees", "better", "disagrees", "undecided")),
    ]  # fmt: skip
    opened = re.search(r"## What is open\n\n(.*?)\n\n", first, re.S)
    assert (opened[1].count("\n- ") + 1 if opened else 0) == words["undecided"]
    assert all(row[5] for row in rows if row[4] == "undecided"), "each says what it would take"


def test_every_row_with_rigid_bodies_has_five_seeds_of_twenty_episodes_or_is_said_to_be_missing():
    text = (PAGES / "performance.md").read_text(encoding="utf-8").partition("## Performance in physics")[2]
    missing = (PAGES / "index.md").read_text(encoding="utf-8").partition("## What is missing")[2]
    rows = [line.strip("| ").split(" | ") for line in text.splitlines() if re.match(r"\| (easy|medium|hard)", line)]
    assert len(rows) >= 4 * 5
    for where, *kind, engine, seeds in (row[:6] for row in rows):
        said = f"{where} with {', '.join(kind)}, {engine.strip('`')} has {seeds} of 5 seeds"
        assert int(seeds) >= 5 or said in missing
    assert all(int(row[10].split(" of ")[1]) == 20 * int(row[5]) for row in rows)


def test_why_six_robots_block_each_other_is_what_the_fit_has_found():
    why = "At none of the values that were tried do the steps with six come near the paper's under that rule"
    assert why in (PAGES / "index.md").read_text(encoding="utf-8")
    lines = (PAGES / "fit.md").read_text(encoding="utf-8").splitlines()
    [names] = [line.strip("| ").split(" | ") for line in lines if line.startswith("| map | measure | the paper | res")]
    [row] = [line.strip("| ").split(" | ") for line in lines if re.match(r"\| hard r5-6 \| steps \|.* of \d", line)]
    close = {name: int(re.search(r"; (\d+) of", cell)[1]) for name, cell in list(zip(names, row, strict=True))[3:]}
    assert [count for name, count in close.items() if name.startswith("two_node")] == [0, 0]
    assert min(count for name, count in close.items() if name.startswith("reservation")) > 0
