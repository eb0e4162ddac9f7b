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
from colonysim.reproduce import STUDIES, plans, reproduce
from colonysim.reproduce.context import Judged
from colonysim.reproduce.document import Heading, Page, Picture, Table, Text, as_html, as_markdown
from colonysim.reproduce.evidence import Evidence, found_by, stored_in_physics
from colonysim.reproduce.facts import FACTS
from colonysim.reproduce.judging import Figure, Reported, direction, level, share
from colonysim.reproduce.pages import PAGES
from colonysim.reproduce.paper import the_paper
from colonysim.reproduce.plans import ABLATED, FULL, QUICK, asked, joined
from colonysim.reproduce.push import ASKED, Trainings
from colonysim.reproduce.recorded import DRAWINGS, RUNS, drawn, recorded
from colonysim.reproduce.summary import summary

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


def test_an_undecided_verdict_says_how_many_seeds_would_decide_it():
    reported = Reported(20.0, 10.0, 400)
    few = [24.0, 12.0, 30.0, 14.0]
    undecided = level(Figure.of(few), reported, "steps")
    assert undecided.word == "undecided" and undecided.takes is not None and undecided.takes > 4
    assert undecided.wanting == f"about {undecided.takes} seeds would do, there are 4"
    assert level(Figure.of(few * 20), reported, "steps").word != "undecided"
    hopeless = level(Figure.of(few), Reported(20.0, 100.0, 40), "steps")
    assert hopeless.word == "undecided" and hopeless.takes is None and "paper's own interval" in hopeless.wanting
    assert level(Figure.of([20.0]), reported, "steps").wanting == "two seeds at least, for an interval"
    noisy = [20.0 + 3.0 * (-1) ** seed for seed in range(8)]
    claim = direction([value + 1.0 for value in reversed(noisy)], noisy, "more")
    assert claim.word == "undecided" and claim.takes is not None and claim.takes > 8
    assert direction(few, few, "more").wanting == "", "what is decided takes nothing"


def test_a_share_of_runs_is_decided_by_its_interval():
    assert [share(there, 20).word for there in (18, 11, 2)] == ["agrees", "undecided", "disagrees"]
    close = share(11, 20)
    assert close.takes is not None
    parts = -(-close.takes // 20)
    assert share(11 * parts, 20 * parts).word == "agrees" and share(11 * (parts - 2), 20 * (parts - 2)).word != "agrees"
    assert share(10, 20).takes is None


def test_equal_values_are_no_difference():
    assert direction([1.0] * 9, [1.0] * 9, "more").word == "disagrees"
    assert direction([1.0] * 9, [1.0] * 9, "same").word == "agrees"


# -- what there is ------------------------------------------------------------------------------------------------


def test_every_claim_drawing_and_fact_belongs_to_a_study():
    assert {claim.study for claim in PAPER.claims} <= set(STUDIES)
    assert {fact.study for fact in FACTS} <= set(STUDIES) and {fact.run for fact in FACTS} <= set(RUNS)
    assert {drawing.run for drawing in DRAWINGS.values()} <= set(RUNS)
    assert set(DRAWINGS) | {"push-ablation"} == set(PAPER.figures)
    assert {claim.of for claim in PAPER.push_claims} | {claim.than for claim in PAPER.push_claims} <= set(ASKED)


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


def test_what_lies_near_a_limit_has_more_seeds_unless_some_are_asked_for():
    def seeds(size, name, parameter):
        [document] = [each for each in plans.ablation(size, name) if parameter in each["grid"]]
        return document["seeds"]["count"]

    for name, parameter in plans.NEAR:
        assert seeds(FULL, name, parameter) == FULL.near_seeds > FULL.seeds == seeds(FULL, name, "policy.beta")
        assert seeds(QUICK, name, parameter) == QUICK.seeds
        assert seeds(replace(FULL, seeds=500), name, parameter) == 500


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
    text = "\n".join(page.read_text() for page in sorted((out / "reproduction").glob("*.md")))
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
        assert (out / "reproduction" / image).is_file()


def test_the_first_page_says_what_holds_and_leads_to_the_others(made):
    out, _, result = made
    text = result.markdown.read_text()
    assert result.markdown == out / "reproduction" / "index.md"
    counted = result.verdicts
    assert (
        f": {counted['agrees']} agree, in {counted['better']} ours is better, {counted['disagrees']} differ, "
        f"{counted['undecided']} are undecided" in text
    )
    assert text.index("## What holds") < text.index("## By subject") < text.index("## Pages")
    links = re.findall(r"\]\(([a-z]+)\.md\)", text)
    assert {"ablations", "pheromones", "push", "verdicts"} == set(links) and "performance" in PAGES
    for name in links:
        assert (out / "reproduction" / f"{name}.md").read_text().startswith("# ")
    verdicts = (out / "reproduction" / "verdicts.md").read_text()
    assert verdicts.count("\n| ") == 2 + sum(counted.values()), "a line each"


def test_the_summary_is_made_from_verdicts_alone():
    def judged(word, **settings):
        verdict = SimpleNamespace(
            word=word, difference=Figure(3.25, 1.0, 5.0, 5), wanting="about 9 seeds would do" * (word == "undecided")
        )
        why = "Because." * (word == "disagrees")
        return Judged("performance-physics", "steps on easy (`x`)", settings["policy"], verdict, settings, 1, why)

    papers = {"policy": "paper", "backend.push": "rl", "backend.feasibility": "forest"}
    found = [judged("agrees", **papers), judged("better", **papers), judged("disagrees", **papers)]
    context = SimpleNamespace(
        judged=[*found, judged("undecided", policy="colony")], evidence=Evidence([]), paper=PAPER, trainings=()
    )
    text = as_markdown(summary(context))
    assert "We set 4 figures and claims of the paper" in text
    assert "1 agree, in 1 ours is better, 1 differ, 1 are undecided" in text
    holds, differs, why, is_open = re.findall(r"(?m)^- (.*)$", text)
    assert holds == "**The paper's rules with a learned push (`rl`, `forest`), rigid bodies:** steps on easy (2 of 3)."
    assert differs.endswith(" steps on easy (1 of 3: +3.2).") and why == "Because."
    assert "| The paper's rules with a learned push (`rl`, `forest`), rigid bodies | 3 | 1 | 1 | 1 | 0 |" in text
    assert "| Our rules `colony` with rigid bodies | 1 | 0 | 0 | 0 | 1 |" in text
    assert is_open == "steps on easy (colony): about 9 seeds would do."


def test_the_page_needs_no_other_file(made):
    page = made[2].html.read_text()
    images = sum(text.read_text().count("![") for text in made[2].markdown.parent.glob("*.md"))
    assert page.count("<img") == images >= 4
    assert not re.findall(r'src="(?!data:)', page) and "<script" not in page
    for target in re.findall(r'href="(.*?)"', page):
        assert f'<section id="{target.removeprefix("#")}">' in page
    assert 'class="undecided"' in page


def test_nothing_is_run_twice_and_more_seeds_are_added(made):
    out, names, _ = made
    begun: list[str] = []

    def watch(outcome, done, total):
        begun.extend([outcome.trial.identity] * (outcome.status == "running"))

    pages = sorted((out / "reproduction").glob("*.md"))
    before = [page.read_bytes() for page in pages]
    reproduce(out, names, size=TINY, workers=2, on_outcome=watch)
    assert not begun and [page.read_bytes() for page in pages] == before
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
    assert not (tmp_path / "reproduction" / "index.md").exists()
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
    text = (made.markdown.parent / "performance.md").read_text()
    for row in PAPER.performance:
        theirs = f"{row.steps[0]:g} ± {row.steps[1]:g}"
        assert f"| {row.label} | `colony` | `staged` | `way` | `bullet` | 3 | {theirs} | 21.0 [18.5, 23.5]" in text
    assert "4 episodes a run" in text and "Runs on `bullet`: seeds 7-9, stored in `bullet.jsonl`." in text
    own, *few = [gap.split(": ")[1] for gap in made.gaps]
    assert own == "no run of the paper's own system, `paper`, `rl`, `forest`." and len(few) == len(PAPER.performance)
    assert few[0] == "easy with `colony`, `staged`, `way`, bullet has 3 of 5 seeds."
    assert "| easy | 22.4 ± 16.1; 0.91 ± 0.16 | 21.0 [18.5, 23.5]; 1.00 [1.00, 1.00]; 3 |" in made.markdown.read_text()
    assert not (tmp_path / "out" / "trials").exists()
    file.write_text('{"setting": 1}\n')
    with pytest.raises(ColonysimError, match="not runs in physics"):
        reproduce(tmp_path / "out", ["performance-physics"], physics=[file])


def test_stored_runs_on_two_engines_stand_side_by_side_and_one_engine_has_one_file(tmp_path):
    files = [stored_runs(tmp_path / f"{name}.jsonl", engine=name) for name in ("bullet", "mujoco")]
    made = reproduce(tmp_path / "out", ["performance-physics"], physics=files)
    text = (made.markdown.parent / "performance.md").read_text()
    for name in ("bullet", "mujoco"):
        assert f"Runs on `{name}`: seeds 7-9, stored in `{name}.jsonl`" in text
        assert f"| easy | `colony` | `staged` | `way` | `{name}` | 3 |" in text
    assert "--physics bullet.jsonl --physics mujoco.jsonl`" in made.markdown.read_text()
    with pytest.raises(ColonysimError, match=r"holds runs on mujoco, as mujoco\.jsonl does"):
        reproduce(tmp_path / "out", ["performance-physics"], physics=[*files, files[1]])
    mixed = tmp_path / "mixed.jsonl"
    mixed.write_text(
        "\n".join(stored_run("easy", "staged", i, engine=name) for i, name in enumerate(("bullet", "mujoco")))
    )
    with pytest.raises(ColonysimError, match="holds runs on bullet, mujoco; expected a file of one engine"):
        reproduce(tmp_path / "out", ["performance-physics"], physics=[mixed])


def test_what_an_engine_is_missing_for_is_a_gap(tmp_path, monkeypatch):
    monkeypatch.setattr("colonysim.reproduce.making.engine_trouble", lambda name: f"{name} is not here")
    made = reproduce(tmp_path / "out", ["trajectories-physics"], size=replace(QUICK, engine="mujoco"))
    assert made.gaps == ("trajectories-physics: mujoco is not here",)


def test_runs_under_several_rules_executors_and_estimates_are_told_apart(tmp_path):
    kinds = [("paper", "rl", "forest"), ("paper", "staged", "way"), ("colony", "rl", "forest")]
    rows = [
        stored_run(name, push, seed, policy=policy, feasibility=estimate)
        for name in MAPS for seed in (7, 8) for policy, push, estimate in kinds
    ]  # fmt: skip
    file = tmp_path / "bullet.jsonl"
    file.write_text("\n".join(rows))
    size = replace(FULL, physics_seeds=2)
    made = reproduce(tmp_path / "out", ["performance-physics"], physics=[file], size=size)
    text = (made.markdown.parent / "performance.md").read_text()
    for policy, push, estimate in kinds:
        assert text.count(f"| `{policy}` | `{push}` | `{estimate}` | `bullet` | 2 |") == len(MAPS)
    assert not made.gaps and "`paper`, `rl`, bullet" in made.markdown.read_text()
    file.write_text(stored_run("easy", "pull", 7))
    with pytest.raises(ColonysimError, match=r"its 'push': 'pull' is not known; there are: "):
        reproduce(tmp_path / "out", ["performance-physics"], physics=[file])


def stored_training(setting: str, seed: int, reward: float, pushed: dict[str, list[float]], base: str = "paper") -> str:
    tests = [[10 * n, 100 * n, 0.5, reward] for n in range(1, 7)]
    return json.dumps({
        "setting": setting, "base": base, "engine": "bullet", "episodes": 400, "seed": seed, "pushes": 200,
        "peak_episode": 300, "actions": 9000, "tests": tests, "pushed": pushed, "pushed_last": pushed,
        "losses": [0.5, 1234.5, 0.1],
    })  # fmt: skip


def test_stored_trainings_are_judged_and_what_is_missing_is_said(tmp_path):
    file = tmp_path / "trainings.jsonl"
    rows = [stored_training("base", seed, 5.0 + 0.1 * seed, {"hole": [0.9, 3.0]}) for seed in range(3)]
    rows += [stored_training("batch 64", seed, 3.0 + 0.1 * seed, {"hole": [0.7, 2.0]}) for seed in range(3)]
    rows += [stored_training("all-in-one", 0, 5.0, {kind: [1.0, 5.0] for kind in ("flat", "slope", "hole")})]
    file.write_text("\n".join(rows))
    made = reproduce(tmp_path / "out", ["push"], trainings=file)
    text = (made.markdown.parent / "push.md").read_text()
    assert "| A batch of 64 generated weaker performance than one of 128. | 5.10 [4.85, 5.35] |" in text
    assert re.search(r"A batch of 64 .*\| 3 \| agrees \|", text)
    assert re.search(r"A batch of 256 .*\| no runs \|", text)
    assert "| `paper` | bullet | 1 | 200 | 300 | 1,234.5 | 1.00 | 1.00 | 1.00 | 1.00 | 1.00 | 1.00 | one seed |" in text
    assert len(made.gaps) == 1 and "`target 600` (0)" in made.gaps[0] and "`all-in-one` (1)" in made.gaps[0]


def test_readings_stand_side_by_side_and_those_with_several_seeds_are_judged(tmp_path):
    file = tmp_path / "trainings.jsonl"
    pushed = {kind: [1.0, 5.0] for kind in ("flat", "slope", "hole")}
    rows = [stored_training("all-in-one", seed, 5.0, pushed, "standard target") for seed in range(3)]
    rows += [stored_training("all-in-one", 100, -5.0, {"flat": [0.0, 0.0]}, "standard target")]
    rows += [stored_training("all-in-one", 0, 5.0, pushed), stored_training("preset", 0, 5.0, pushed, "improved")]
    file.write_text("\n".join(rows))
    made = reproduce(tmp_path / "out", ["push"], trainings=file)
    text = (made.markdown.parent / "push.md").read_text()
    assert [line.split(" | ")[0] for line in text.splitlines() if " | bullet | " in line] == [
        "| `paper`", "| `standard target`", "| `improved`",
    ]  # fmt: skip
    assert re.findall(r"### All-in-One, with the reading (.*)", text) == ["`standard target`, bullet"]
    assert "| better, agrees, better |" in text
    assert "several seeds, `standard target`, bullet is shown to reach the paper's success" in text
    first = made.markdown.read_text()
    assert (
        "in the paper 0.94, 1.00, 0.90 after 400 training episodes; here of trainings of 400 episodes to the letter on "
        "bullet 1.00, 1.00, 1.00 (1 training, the best after 300 episodes on average; the last networks 1.00, 1.00, "
        "1.00); by the reading `standard target` on bullet 1.00 [1.00, 1.00], 1.00 [1.00, 1.00], 1.00 [1.00, 1.00] "
        "(3 trainings, " in first
    )
    assert (made.markdown.parent / "push-readings.png").stat().st_size > 5000


def test_an_image_is_of_the_run_that_is_asked_for_and_a_damaged_run_is_made_again(tmp_path):
    pytest.importorskip("matplotlib")

    def image(seed: int) -> bytes:
        return drawn("sanity-D", replace(TINY, first_seed=seed), tmp_path / "runs", tmp_path).read_bytes()

    first, second = image(10), image(11)
    assert first != second and image(10) == first
    run = recorded(RUNS["sanity"], TINY, tmp_path / "runs")
    [part, *_] = sorted((run.path / "deposits").iterdir())
    part.write_bytes(part.read_bytes()[:100])
    assert recorded(RUNS["sanity"], TINY, tmp_path / "runs").verify()


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"map": "eazy"}, "the paper has no map 'eazy'"), ({"map": "hard:r9-9"}, "the paper has no map 'hard:r9-9'"),
        ({"policy": "colonny"}, "did you mean 'colony'?"), ({"policy": None}, "its 'policy'"),
        ({"feasibility": "oracle"}, "'oracle' is not known"), ({"parameters": None}, "its 'parameters'"),
        ({"parameters": {"a": [1]}}, "its 'parameters'"), ({"episodes": []}, "its 'episodes'"),
        ({"seed": 10**30}, "its 'seed'"), ({"engine": "bulet"}, "did you mean 'bullet'?"),
        *[
            ({"episodes": [{**json.loads(stored_run("easy", "staged", 7))["episodes"][0], **part}]}, name)
            for name, part in [
                ("(0.success)", {"success": 5.0}), ("(0.steps)", {"steps": -40}), ("(0.steps)", {"steps": 10**400}),
                ("(0.success)", {"success": float("nan")}), ("(0.sim_seconds)", {"sim_seconds": -1.0}),
            ]
        ],
    ],
)  # fmt: skip
def test_a_stored_run_that_cannot_be_is_left_out_and_it_is_said_why(tmp_path, changed, said):
    file = tmp_path / "bullet.jsonl"
    whole = stored_run("easy", "staged", 7)
    file.write_text(f"{whole}\n{json.dumps({**json.loads(whole), **changed})}\n")
    _, runs, [told] = stored_in_physics(file)
    assert len(runs) == 1 and said in told


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"setting": "batch 65"}, "'batch 65' is not known"), ({"base": "../x"}, "'../x' is not known"),
        ({"engine": None}, "its 'engine'"), ({"pushed": {"flat": None}}, "its 'pushed'"),
        ({"pushed": {"flat": [5.0, 1.0]}}, "its 'pushed'"), ({"pushes": None}, "its 'pushes'"),
        ({"losses": "abc"}, "its 'losses'"), ({"peak_episode": 10**400}, "its 'peak_episode'"),
        ({"tests": []}, "its 'tests'"), ({"pushed_last": None}, "its 'pushed_last'"),
    ],
)  # fmt: skip
def test_a_stored_training_that_cannot_be_is_left_out_and_it_is_said_why(tmp_path, changed, said):
    file = tmp_path / "trainings.jsonl"
    whole = stored_training("base", 0, 1.0, {"hole": [1.0, 2.0]})
    file.write_text(f"{whole}\n{json.dumps({**json.loads(whole), 'seed': 1, **changed})}\n")
    [found], [told] = Trainings.read(file)
    assert len(found.rows) == 1 and "line 2: " in told and said in told


def test_the_same_run_in_other_words_counts_once(tmp_path):
    file = tmp_path / "bullet.jsonl"
    hard, easy = stored_run("hard", "staged", 7), stored_run("easy", "staged", 7)
    spelled = [("hard:r20-4", {}), ("easy:", {}), ("easy", {"policy": "colony"}), ("easy", {"feasibility": "way"})]
    others = [stored_run(name, "staged", 7, **more) for name, more in [*spelled, ("easy", {"engine": "bullet"})]]
    file.write_text("\n".join([hard, easy, *others]))
    _, runs, [told] = stored_in_physics(file)
    assert len(runs) == 2 and told.count("it is there twice") == 5


def test_rows_of_another_length_are_left_out_and_counted(tmp_path):
    file = tmp_path / "rows.jsonl"
    short = json.loads(stored_run("easy", "staged", 9))
    short["episodes"] = short["episodes"][:1]
    file.write_text("\n".join([*(stored_run("easy", "staged", seed) for seed in (7, 8)), json.dumps(short)]))
    _, runs, [told] = stored_in_physics(file)
    assert [run.seed for run in runs] == [7, 8] and "1 of 3 rows have other than 4 episodes; left out" in told
    trained = [json.loads(stored_training("base", seed, 1.0, {})) for seed in range(3)]
    trained[2]["episodes"] = 401
    file.write_text("\n".join(map(json.dumps, trained)))
    [found], [told] = Trainings.read(file)
    assert len(found.rows) == 2 and "1 of 3 rows have other than 400 episodes; left out" in told
    file.write_text("")
    with pytest.raises(ColonysimError, match="it is empty"):
        stored_in_physics(file)


def test_a_reading_that_was_trained_on_all_terrains_alone_has_its_figures_and_no_claims(tmp_path):
    file = tmp_path / "trainings.jsonl"
    pushed = {kind: [0.25, 5.0] for kind in ("flat", "slope", "hole")}
    file.write_text("\n".join(stored_training("all-in-one", seed, 5.0, pushed) for seed in range(3)))
    made = reproduce(tmp_path / "out", ["push"], trainings=file)
    text = (made.markdown.parent / "push.md").read_text()
    assert "### All-in-One, with the reading `paper`, bullet" in text and "| individual |" not in text
    assert not made.gaps and made.verdicts.total() == 6 and "no runs" not in text


def test_a_report_of_other_studies_leaves_no_page_and_no_link_of_the_one_before(tmp_path):
    file = tmp_path / "trainings.jsonl"
    file.write_text(stored_training("base", 0, 1.0, {"hole": [1.0, 2.0]}))
    made = reproduce(tmp_path / "out", ["push"], trainings=file)
    assert "node world with seeds" not in made.markdown.read_text()
    made = reproduce(tmp_path / "out", ["performance-physics"], physics=[stored_runs(tmp_path / "bullet.jsonl")])
    assert not (made.markdown.parent / "push.md").exists() and "push.md" not in made.markdown.read_text()


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
    page = as_html([Page("first", [*blocks, Text("see [the other](second.md)")]), Page("second", [])], tmp_path)
    assert '<section id="second">' in page and 'see <a href="#second">the other</a>' in page
    assert "<h1>Of &lt;this&gt;</h1>" in page and "<li><code>one</code> &amp; <em>two</em></li>" in page
    assert 'src="data:image/png;base64,aW1hZ2U="' in page and '<td class="disagrees">disagrees (above): so</td>' in page
    with pytest.raises(ColonysimError, match="cannot be read"):
        as_html([Page("first", [Picture("b.png", "")])], tmp_path)


def test_damaged_lines_of_stored_results_are_missing_and_the_others_count(tmp_path):
    file = tmp_path / "bullet.jsonl"
    whole = [stored_run("easy", "staged", seed).encode() for seed in (7, 8, 9)]
    lines = [whole[0], b"", whole[1][:-9], b"\0" * 40, b"\xff{}", whole[0], whole[2].replace(b"20", b"null"), whole[2]]
    file.write_bytes(b"\n".join(lines))
    engine, runs, [told] = stored_in_physics(file)
    assert engine == "bullet"
    assert [run.seed for run in runs] == [7, 9]
    assert re.findall(r"line (\d+): ", told) == ["2", "3", "4", "5", "6", "7"]
    assert "it is there twice (bullet, easy, colony, staged, way, 7)" in told
    row = json.loads(stored_training("base", 1, 1.0, {"hole": [1.0, 2.0]}))
    trainings = tmp_path / "trainings.jsonl"
    other = json.dumps({**row, "seed": 2, "tests": [[1, 2, "x", 0.0]]})
    trainings.write_text(f"{json.dumps(row)}\n{other}\nnonsense\n")
    [found], [told] = Trainings.read(trainings)
    assert len(found.rows) == 1 and "line 2: its 'tests' (0.2): " in told and "line 3: " in told
    trainings.write_text("nonsense\n")
    with pytest.raises(ColonysimError, match="not trainings as"):
        Trainings.read(trainings)
