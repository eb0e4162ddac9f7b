"""What is played through an environment is what the simulation does by itself."""

from __future__ import annotations

import pytest

pytest.importorskip("pettingzoo")

import colonysim
from colonysim import rl
from colonysim.scenario.loading import load_variants
from colonysim.trace.reader import Run

HARD = [variant for variant, _ in load_variants("hard")]


def play(env):
    """An episode of the scenario's own policy."""
    for agent in env.agent_iter():
        env.step(None if env.terminations[agent] or env.truncations[agent] else env.choice())


def native(name, variant, seed, episodes, **more):
    return colonysim.run(name, variant=variant, seed=seed, episodes=episodes, trace=False, **more).manifest


@pytest.mark.parametrize("variant", HARD)
def test_colony_through_aec_has_the_trace_hash_of_the_native_run_on_hard(variant, tmp_path):
    env = rl.aec("hard", variant=variant, pheromones="keep", overrides={"episodes": 2}, trace=tmp_path)
    env.reset(seed=3)
    play(env)
    env.reset()
    play(env)
    env.close()
    run = Run.open(tmp_path / "run-000001")
    assert run.manifest["status"] == "finished"
    expected = native("hard", variant, 3, 2)
    assert run.manifest["trace_sha256"] == expected["trace_sha256"]
    assert run.manifest["rows"] == expected["rows"]


@pytest.mark.parametrize("engine", ["mujoco", "bullet"])
def test_it_has_it_in_physics(engine, tmp_path):
    pytest.importorskip({"mujoco": "mujoco", "bullet": "pybullet"}[engine])
    overrides = {"max_steps": 12}
    env = rl.aec("sanity", backend=engine, trace=tmp_path, overrides=overrides)
    env.reset(seed=1)
    play(env)
    env.close()
    expected = native("sanity", None, 1, 1, backend=engine, overrides=overrides)
    assert Run.open(tmp_path / "run-000001").manifest["trace_sha256"] == expected["trace_sha256"]


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_all_doors_lead_to_the_same_episode(mode, tmp_path):
    doors = (rl.aec, rl.parallel, rl.multi_agent)
    aec, parallel, multi = (make("hard", mode=mode, seed=2, trace=tmp_path / make.__name__) for make in doors)
    aec.reset()
    play(aec)
    for env in (parallel, multi):
        env.reset()
        while env.agents:
            env.step({f"robot_{agent}": env.turns.choice(agent) for agent in env.turns.together})
    hashes = set()
    for env in (aec, parallel, multi):
        env.close()
    for name in ("aec", "parallel", "multi_agent"):
        hashes.add(Run.open(tmp_path / name / "run-000001").manifest["trace_sha256"])
    expected = native("hard", None, 2, 1, mode=mode)
    assert hashes == {expected["trace_sha256"]}


def test_runs_that_are_left_in_the_middle_can_be_read(tmp_path):
    env = rl.aec("hard", trace=tmp_path)
    env.reset(seed=1)
    for _ in range(20):
        env.step(env.choice())
    env.reset()
    play(env)
    env.reset()
    env.close()
    runs = [Run.open(path) for path in sorted(tmp_path.iterdir())]
    assert [run.manifest["status"] for run in runs] == ["interrupted", "finished", "interrupted"]
    assert [episode.ended for episode in runs[0].episodes] == ["interrupted"]
    assert len({run.manifest["seed"] for run in runs}) == 3
    assert all(run.manifest["policy"] == "outside-colony" for run in runs)


def test_what_was_played_can_be_verified_shown_and_plotted(tmp_path):
    from typer.testing import CliRunner

    from colonysim.cli import app
    from colonysim.plots import draw
    from colonysim.video import write_video
    from colonysim.view import write_page

    env = rl.aec("hard", trace=tmp_path, policy="random")
    env.reset(seed=1)
    for agent in env.agent_iter():
        done = env.terminations[agent] or env.truncations[agent]
        env.step(None if done else env.action_space(agent).sample(env.infos[agent]["action_mask"]))
    env.close()
    run = Run.open(tmp_path / "run-000001")
    assert CliRunner().invoke(app, ["verify", str(run.path)]).exit_code == 0
    assert write_page(run, tmp_path / "page.html").stat().st_size > 10_000
    assert draw(run, what=["trajectories"], out=tmp_path / "plots")
    assert write_video(run, tmp_path / "film.gif").stat().st_size > 10_000
