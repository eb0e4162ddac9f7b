"""The fit of the parameters that the paper does not print."""

from __future__ import annotations

from dataclasses import replace

import pytest

from colonysim.policies.settings import PRESETS, StigmergySettings
from colonysim.reproduce import plans, reproduce
from colonysim.reproduce.context import Context
from colonysim.reproduce.evidence import Evidence, Measured
from colonysim.reproduce.fit import Point, distance, driven_part, held_out, points
from colonysim.reproduce.paper import the_paper
from colonysim.reproduce.plans import ALTERNATIVES, FITTED, FITTED_READINGS, PRESET_POINT, QUICK, asked

PAPER = the_paper()
TINY = replace(QUICK, first_seed=10, fit_points=1, held_out_seeds=2)


def trials(parameters: dict[str, object], seeds: list[int], off: float, backend: str = "nodeworld") -> list[Measured]:
    """Runs that are off the paper's means by so many of its standard deviations (of steps downwards)."""
    made = []
    for row in PAPER.performance:
        episodes = [
            {
                "episode": n, "ended": "goal", "steps": row.steps[0] + (side - off) * row.steps[1],
                "success": row.success[0] + (side + off) * row.success[1],
            }
            for n, side in enumerate((-1.0, 1.0), 1)
        ]  # fmt: skip
        settings = {"scenario": row.map, "variant": row.variant, "mode": "asynchronous", "policy": "paper"}
        settings["backend"] = backend
        made += [Measured(settings, parameters, seed, tuple(episodes)) for seed in seeds]
    return made


def test_the_nearer_a_point_lies_to_the_paper_s_rows_the_less_its_distance():
    far = []
    for off in (0.0, 0.5, 1.0):
        [point] = points(Evidence(trials(PRESET_POINT, [10, 11], off)), PAPER, 10, 2)
        far.append(distance(PAPER, point, point.seeds()))
    assert far[0] < 0.5 < far[1] < far[2], "what is left at 0 is that a sample's deviation is the larger of few"


def test_a_point_needs_all_rows_and_only_seeds_that_are_asked_for_count():
    every = trials(PRESET_POINT, [10, 11], 0.0)
    assert points(Evidence(every[:-2]), PAPER, 10, 2) == []
    assert points(Evidence(every), PAPER, 12, 2) == []
    assert points(Evidence(trials({"policy.beta": 1.0}, [10], 0.0)), PAPER, 10, 1) == []
    [point] = points(Evidence(every), PAPER, 10, 1)
    assert point.seeds() == [10]
    driven = trials(PRESET_POINT, [2000], 0.0, "mujoco")
    assert points(Evidence(driven), PAPER, 0, 10**6) == []
    assert len(points(Evidence(driven), PAPER, 0, 10**6, backend="mujoco")) == 1


def test_the_best_of_each_reading_and_the_preset_are_run_with_seeds_by_which_nothing_was_chosen():
    better = {**PRESET_POINT, "policy.beta": 3.0}
    other = {**PRESET_POINT, "policy.collision": "reservation"}
    found = Evidence([*trials(PRESET_POINT, [10], 1.0), *trials(better, [10], 0.1), *trials(other, [10], 0.5)])
    documents = held_out(replace(QUICK, first_seed=10), found, PAPER)
    assert [{name: value for name, [value] in document["grid"].items()} for document in documents] == [
        better, other, PRESET_POINT,
    ]  # fmt: skip
    fresh = {trial.seed for trial in asked(documents)}
    assert len(fresh) == QUICK.held_out_seeds
    assert not fresh & {trial.seed for trial in asked(plans.fit(replace(QUICK, first_seed=10)))}
    assert held_out(QUICK, Evidence([]), PAPER) == []


def test_the_preset_s_point_is_the_preset_and_every_alternative_is_another_reading():
    preset = StigmergySettings(**PRESETS["paper"])
    assert set(PRESET_POINT) == {*FITTED, *FITTED_READINGS}
    for name, value in PRESET_POINT.items():
        assert getattr(preset, name.removeprefix("policy.")) == value
    for name, value in ALTERNATIVES.items():
        assert getattr(preset, name.removeprefix("policy.")) != value
        StigmergySettings(**{**PRESETS["paper"], name.removeprefix("policy."): value})


def test_the_page_shows_the_best_points_beside_the_preset(tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.setattr(plans, "ALTERNATIVES", {"policy.patience": 5.0})
    monkeypatch.setattr("colonysim.reproduce.fit.ALTERNATIVES", {"policy.patience": 5.0})
    begun: list[str] = []

    def watch(outcome, done, total):
        begun.extend([outcome.trial.identity] * (outcome.status == "running"))

    made = reproduce(tmp_path, ["fit"], size=TINY, workers=2, on_outcome=watch)
    text = (tmp_path / "reproduction" / "fit.md").read_text()
    assert "4 points on the node world" in text and "seeds 500010-500011" in text
    assert "| hard r5-6 | success | 0.73 |" in text and "of the 10 figures are close" in text
    assert "| the preset |" in text and "| `patience` 5.0 |" in text
    assert sum(made.verdicts.values()) == 2 * len(PAPER.performance)
    assert (tmp_path / "reproduction" / "fit.png").stat().st_size > 5000
    assert len(begun) == len(set(begun)) == 5 * (4 + 2) + 5 * 5 * 2
    reproduce(tmp_path, ["fit"], size=TINY, workers=2, on_outcome=watch)
    assert len(begun) == 80, "nothing is run twice"


def test_only_the_paper_s_system_at_the_best_point_counts_with_rigid_bodies(tmp_path):
    def driven(parameters: dict[str, object], push: str, feasibility: str, off: float) -> list[Measured]:
        options = {"backend.push": push, "backend.feasibility": feasibility}
        found = trials(parameters, [2000, 2001], off, "mujoco")
        return [replace(trial, settings={**trial.settings, **options}) for trial in found]

    elsewhere = {**PRESET_POINT, "policy.beta": 3.0}
    own = driven(PRESET_POINT, "rl", "forest", 0.0)
    others = [
        *driven(PRESET_POINT, "staged", "way", 9.0), *driven(elsewhere, "rl", "forest", 9.0),
        *driven({"policy.beta": 1.0}, "rl", "forest", 9.0),
    ]  # fmt: skip
    context = Context(tmp_path, TINY, PAPER, Evidence([*own, *others]), (), {}, [])
    [_, _, table] = driven_part(context, Point(PRESET_POINT, {}))
    assert [(row[1], row[3]) for row in table.rows] == [("mujoco", "2")] * len(PAPER.performance)
    assert len(context.judged) == 2 * len(PAPER.performance)
    assert {each.verdict.word for each in context.judged} == {"agrees"}
    assert len(context.gaps) == 1 and "30 of 40 stored runs on mujoco with parameters set" in context.gaps[0]
