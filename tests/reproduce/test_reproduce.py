"""A tiny reproduction: what is run, kept, judged and written."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

from colonysim.cli import app
from colonysim.errors import ColonysimError
from colonysim.reproduce import STUDIES, reproduce
from colonysim.reproduce.document import Heading, Picture, Table, Text, as_html, as_markdown
from colonysim.reproduce.evidence import Evidence, found_by, stored_in_physics
from colonysim.reproduce.facts import FACTS
from colonysim.reproduce.judging import Figure, Reported, direction, level
from colonysim.reproduce.paper import the_paper
from colonysim.reproduce.plans import ABLATED, FULL, QUICK, asked, joined
from colonysim.reproduce.push import SETTINGS, Trainings
from colonysim.reproduce.recorded import DRAWINGS, RUNS

TINY = replace(QUICK, seeds=2, first_seed=10, episodes=3, drawn=2)
PAPER = the_paper()

pytest.importorskip("matplotlib")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    out = tmp_path_factory.mktemp("reproduced") / "out"
    names = ["ablation-sanity", "hole-edge-case", "push"]
    return out, names, reproduce(out, names, size=TINY, workers=2)


# -- the rule -----------------------------------------------------------------------------------------------------


def test_a_figure_agrees_is_better_disagrees_or_is_undecided():
    reported = Reported(20.0, 10.0, 40)
    narrow = [19.0, 20.0, 21.0, 20.0] * 5
    assert level(Figure.of(narrow), reported, "steps").word == "agrees"
    above = level(Figure.of([value + 9 for value in narrow]), reported, "steps")
    assert (above.word, above.side) == ("disagrees", "above")
    assert above.difference is not None and above.difference.low is not None and above.difference.low > 0
    below = level(Figure.of([value - 9 for value in narrow]), reported, "steps")
    assert (below.word, below.side) == ("better", "below"), "fewer steps"
    successes = Figure.of([0.95, 1.0] * 10)
    assert level(successes, Reported(0.5, 0.1, 40), "success").word == "better"
    assert level(successes, Reported(1.0, 0.01, 40), "success").word == "disagrees"
    assert level(Figure.of([2.0, 38.0, 20.0]), reported, "steps").word == "undecided", "too wide to say"
    assert level(Figure.of([20.0]), reported, "steps").word == "undecided", "one seed has no interval"
    assert level(None, reported, "steps").word == "undecided"


@pytest.mark.parametrize(
    ("shift", "noise", "expected", "word"),
    [
        (5.0, 1.0, "more", "agrees"),
        (-5.0, 1.0, "more", "disagrees"),
        (-5.0, 1.0, "less", "agrees"),
        (5.0, 1.0, "less", "disagrees"),
        (0.0, 0.5, "more", "disagrees"),  # no difference worth the name
        (0.0, 20.0, "more", "undecided"),
        (0.0, 0.5, "same", "agrees"),
        (5.0, 1.0, "same", "disagrees"),
        (1.9, 1.0, "same", "undecided"),
    ],
)
def test_a_claim_is_tested_on_differences_of_the_same_seed(shift, noise, expected, word):
    # What differs between seeds is large, and no matter.
    other = [20.0 + 10.0 * (-1) ** seed for seed in range(12)]
    one = [value + shift + noise * ((seed % 4) - 1.5) for seed, value in enumerate(other)]
    assert direction(one, other, expected).word == word
    assert direction(one[:1], other[:1], expected).word == "undecided"


def test_equal_values_are_no_difference():
    assert direction([1.0] * 9, [1.0] * 9, "more").word == "disagrees"
    assert direction([1.0] * 9, [1.0] * 9, "same").word == "agrees"


# -- what there is ------------------------------------------------------------------------------------------------


def test_every_claim_drawing_and_fact_belongs_to_a_study():
    assert {claim.study for claim in PAPER.claims} <= set(STUDIES)
    assert {fact.study for fact in FACTS} <= set(STUDIES) and {fact.run for fact in FACTS} <= set(RUNS)
    assert {drawing.run for drawing in DRAWINGS.values()} <= set(RUNS)
    assert set(DRAWINGS) | {"push-ablation"} == set(PAPER.figures)
    assert {claim.of for claim in PAPER.push_claims} | {claim.than for claim in PAPER.push_claims} <= set(SETTINGS)


def test_every_claim_finds_its_trials():
    trials = asked(document for study in STUDIES.values() for document in study.trials(TINY))
    for claim in PAPER.claims:
        for side in (claim.of, claim.than):
            wanted = {**claim.where, **side}
            fitting = [trial for trial in trials if wanted.items() <= trial.described().items()]
            assert any(set(trial.parameters) <= set(wanted) for trial in fitting), claim.name


def test_a_full_reproduction_takes_up_what_a_quick_one_has_run():
    quick, full = (
        {t.identity for t in joined(asked(STUDIES["asynchrony"].trials(size))).trials} for size in (QUICK, FULL)
    )
    assert quick < full


def test_a_trial_that_two_studies_ask_for_is_run_once_and_found_by_both():
    trials = asked([*STUDIES["ablation-easy"].trials(TINY), *STUDIES["asynchrony"].trials(TINY)])
    once = joined(trials).trials
    assert len(once) < len(trials) and len({trial.identity for trial in once}) == len(once)
    entry = {"status": "succeeded", "episodes": [[1, 20, 1.0, "goal", 30.0, 2]]}
    store = SimpleNamespace(entries={trial.identity: entry for trial in once})
    measured, missing = found_by(trials, store)
    evidence = Evidence(measured)
    assert not missing
    for preset in ("paper", "colony"):
        where = {"scenario": "easy", "variant": None, "backend": "nodeworld", "mode": "synchronous", "policy": preset}
        assert set(evidence.matching(where).by_seed("steps")) == {10, 11}
        for parameter, values in ABLATED["easy"].items():
            for value in values:
                assert set(evidence.matching({**where, parameter: value}).by_seed("steps")) == {10, 11}, parameter


# -- the report ---------------------------------------------------------------------------------------------------


def test_the_report_holds_every_claim_of_its_studies_with_a_verdict(made):
    out, names, result = made
    text = result.markdown.read_text()
    claims = [claim for claim in PAPER.claims if claim.study in names]
    for claim in claims:
        lines = [line for line in text.splitlines() if line.startswith(f"| {claim.says} (")]
        assert len(lines) == 2, "under both presets"
        assert all(re.search(r"\| (agrees|disagrees|undecided)[^|]* \|$", line) for line in lines)
    assert len(claims) >= 4 and sum(result.verdicts.values()) > 2 * len(claims)
    assert "AblationEasy" not in text
    assert f"`colonysim reproduce {' '.join(names)} " in text, "the report names the command that made it"
    assert (out / "reproduction" / "ablation-sanity-paper.png").stat().st_size > 5000
    for image in re.findall(r"\]\((.*?\.png)\)", text):
        assert (out / image).is_file()


def test_the_page_needs_no_other_file(made):
    page = made[2].html.read_text()
    assert page.count("<img") == len(re.findall(r"!\[", made[2].markdown.read_text())) >= 4
    assert not re.findall(r'(?:src|href)="(?!data:)', page) and "<script" not in page
    assert 'class="undecided"' in page


def test_nothing_is_run_twice_and_more_seeds_are_added(made):
    out, names, _ = made
    begun: list[str] = []

    def watch(outcome, done, total):
        begun.extend([outcome.trial.identity] * (outcome.status == "running"))

    before = (out / "reproduction.md").read_bytes()
    reproduce(out, names, size=TINY, workers=2, on_outcome=watch)
    assert not begun and (out / "reproduction.md").read_bytes() == before
    reproduce(out, ["ablation-sanity"], size=replace(TINY, seeds=3), workers=2, on_outcome=watch)
    assert len(begun) == 30, "one more seed of 15 values under two presets"


def test_a_killed_reproduction_goes_on(made, tmp_path):
    words = ["ablation-sanity", "--out", str(tmp_path), "--first-seed", "10", "--seeds", "2", "--quick", "-w", "2"]
    command = [sys.executable, "-m", "colonysim", "reproduce", *words]
    process = subprocess.Popen(command, start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    journal = tmp_path / "trials" / "journal.jsonl"
    while process.poll() is None and (not journal.exists() or journal.read_bytes().count(b"succeeded") < 5):
        time.sleep(0.01)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    assert not (tmp_path / "reproduction.md").exists()
    answer = CliRunner().invoke(app, ["reproduce", *words])
    assert answer.exit_code == 0 and "agrees" in answer.stdout, answer.output
    entries = [json.loads(line) for line in journal.read_text().splitlines()]
    ends = [entry["trial"] for entry in entries if entry["status"] == "succeeded"]
    assert len(ends) == len(set(ends)) == 60


def stored_run(scenario: str, push: str, seed: int, **more: str) -> str:
    episode = {"steps": 20 + seed % 3, "success": 1.0, "ended": "goal", "seated": 2, "sim_seconds": 80.0}
    return json.dumps({"map": scenario, "push": push, "seed": seed, "episodes": [episode] * 4, **more})


MAPS = ("easy", "medium", "hard", "hard:r5-4", "hard:r5-6")


def stored_runs(file: Path, **more: str) -> Path:
    file.write_text("\n".join(stored_run(name, "staged", seed, **more) for name in MAPS for seed in (7, 8, 9)))
    return file


def test_stored_runs_in_physics_take_the_place_of_new_ones(tmp_path):
    file = stored_runs(tmp_path / "bullet.jsonl")
    made = reproduce(tmp_path / "out", ["performance-physics"], physics=[file])
    text = made.markdown.read_text()
    for row in PAPER.performance:
        theirs = f"{row.steps[0]:g} ± {row.steps[1]:g}"
        assert f"| {row.label} | `colony`, `staged`, bullet | 3 | {theirs} | 21.0 [18.5, 23.5]" in text
    assert "seeds 7-9, 4 episodes a run, stored in `bullet.jsonl`" in text and not made.gaps
    assert not (tmp_path / "out" / "trials").exists()
    file.write_text('{"setting": 1}\n')
    with pytest.raises(ColonysimError, match="not runs in physics"):
        reproduce(tmp_path / "out", ["performance-physics"], physics=[file])


def test_stored_runs_on_two_engines_stand_side_by_side_and_one_engine_has_one_file(tmp_path):
    files = [stored_runs(tmp_path / f"{name}.jsonl", engine=name) for name in ("bullet", "mujoco")]
    made = reproduce(tmp_path / "out", ["performance-physics"], physics=files)
    text = made.markdown.read_text()
    for name in ("bullet", "mujoco"):
        assert f"on the engine `{name}`" in text and f"stored in `{name}.jsonl`" in text
        assert f"| easy | `colony`, `staged`, {name} | 3 |" in text
    assert "--physics bullet.jsonl --physics mujoco.jsonl`" in text and not made.gaps
    with pytest.raises(ColonysimError, match=r"holds runs on mujoco, as mujoco\.jsonl does"):
        reproduce(tmp_path / "out", ["performance-physics"], physics=[*files, files[1]])
    mixed = tmp_path / "mixed.jsonl"
    mixed.write_text("\n".join(stored_run("easy", "staged", i, engine=name) for i, name in enumerate(("bullet", "x"))))
    with pytest.raises(ColonysimError, match="holds runs on bullet, x; expected a file of one engine"):
        reproduce(tmp_path / "out", ["performance-physics"], physics=[mixed])


def test_what_an_engine_is_missing_for_is_a_gap(tmp_path, monkeypatch):
    monkeypatch.setattr("colonysim.reproduce.making.engine_trouble", lambda name: f"{name} is not here")
    made = reproduce(tmp_path / "out", ["trajectories-physics"], size=replace(QUICK, engine="mujoco"))
    assert made.gaps == ("trajectories-physics: mujoco is not here",)


def stored_training(setting: str, seed: int, reward: float, pushed: dict[str, list[float]]) -> str:
    tests = [[10 * n, 100 * n, 0.5, reward] for n in range(1, 7)]
    return json.dumps({
        "setting": setting, "base": "paper", "episodes": 400, "seed": seed, "pushes": 200, "peak_episode": 300,
        "actions": 9000, "tests": tests, "pushed": pushed,
    })  # fmt: skip


def test_stored_trainings_are_judged_and_what_is_missing_is_said(tmp_path):
    file = tmp_path / "trainings.jsonl"
    rows = [stored_training("base", seed, 5.0 + 0.1 * seed, {"hole": [0.9, 3.0]}) for seed in range(3)]
    rows += [stored_training("batch 64", seed, 3.0 + 0.1 * seed, {"hole": [0.7, 2.0]}) for seed in range(3)]
    rows += [stored_training("all-in-one", 0, 5.0, {kind: [1.0, 5.0] for kind in ("flat", "slope", "hole")})]
    file.write_text("\n".join(rows))
    made = reproduce(tmp_path / "out", ["push"], trainings=file)
    text = made.markdown.read_text()
    assert "| A batch of 64 generated weaker performance than one of 128. | 5.10 [4.85, 5.35] |" in text
    assert re.search(r"A batch of 64 .*\| 3 \| agrees \|", text)
    assert re.search(r"A batch of 256 .*\| undecided \|", text)
    assert len(made.gaps) == 1 and "`target 600` (0)" in made.gaps[0] and "`all-in-one` (1)" in made.gaps[0]


def test_what_is_asked_for_wrongly_is_one_message(tmp_path):
    with pytest.raises(ColonysimError, match="did you mean 'ablation-easy'"):
        reproduce(tmp_path, ["ablation-eassy"])
    answer = CliRunner().invoke(app, ["reproduce", "--list"])
    assert answer.exit_code == 0 and all(name in answer.stdout for name in STUDIES)
    assert CliRunner().invoke(app, ["reproduce", "push"]).exit_code == 2


def test_a_report_as_markdown_and_html(tmp_path):
    (tmp_path / "a.png").write_bytes(b"image")
    blocks = [
        Heading(1, "Of <this>"), Text("- `one` & *two*\n- **three**"), Picture("a.png", "An image"),
        Table(["a|b", "verdict"], [["x|y", "disagrees (above): so"]]),
    ]  # fmt: skip
    text = as_markdown(blocks)
    assert text.startswith("# Of <this>\n\n- `one`") and "| x&#124;y | disagrees" in text
    page = as_html(blocks, tmp_path)
    assert "<h1>Of &lt;this&gt;</h1>" in page and "<li><code>one</code> &amp; <em>two</em></li>" in page
    assert 'src="data:image/png;base64,aW1hZ2U="' in page and '<td class="disagrees">disagrees (above): so</td>' in page
    with pytest.raises(ColonysimError, match="cannot be read"):
        as_html([Picture("b.png", "")], tmp_path)


def test_damaged_lines_of_stored_results_are_missing_and_the_others_count(tmp_path):
    file = tmp_path / "bullet.jsonl"
    whole = [stored_run("easy", "staged", seed).encode() for seed in (7, 8, 9)]
    lines = [whole[0], b"", whole[1][:-9], b"\0" * 40, b"\xff{}", whole[0], whole[2].replace(b"20", b"null"), whole[2]]
    file.write_bytes(b"\n".join(lines))
    engine, runs, [told] = stored_in_physics(file)
    assert engine == "bullet"
    assert [run.seed for run in runs] == [7, 9]
    assert re.findall(r"line (\d+): ", told) == ["2", "3", "4", "5", "6", "7"]
    assert "it is there twice (easy, staged, 7)" in told
    row = {"setting": "base", "base": "paper", "episodes": 9, "seed": 1, "peak_episode": 3, "pushed": {}, "tests": []}
    trainings = tmp_path / "trainings.jsonl"
    other = json.dumps({**row, "seed": 2, "tests": [[1, 2, "x", 0.0]]})
    trainings.write_text(f"{json.dumps(row)}\n{other}\nnonsense\n")
    found, [told] = Trainings.read(trainings)
    assert found is not None and len(found.rows) == 1 and "line 2: its 'tests'" in told and "line 3: " in told
    trainings.write_text("nonsense\n")
    with pytest.raises(ColonysimError, match="not trainings as"):
        Trainings.read(trainings)
