"""The names by which a physics engine is asked for: a backend's, and the scenario's own."""

from __future__ import annotations

import re
from typing import Any

import pytest
from backends.places import LANE, place

import colonysim
from colonysim.backends.physics import Physics
from colonysim.errors import ColonysimError, MissingExtraError, ScenarioError
from colonysim.installing import install_command
from colonysim.physics import engine_version
from colonysim.plugins import PHYSICS, make_backend


def run(backend: str, **physics: Any) -> colonysim.Run:
    scenario = place({**LANE, "max_steps": 2, "physics": physics})
    return colonysim.run(scenario, backend=backend, episodes=1, trace=False, backend_options={"push": "scripted"})


def test_a_run_says_which_engine_it_was_however_it_was_asked_for(engine: str) -> None:
    by_name, by_default, by_scenario = run(engine), run("physics"), run("physics", engine=engine)
    for made in (by_name, by_default, by_scenario):
        assert made.manifest["backend"] == engine
        assert (made.manifest["engine"]["name"], made.manifest["engine"]["version"]) == (engine, engine_version(engine))
    assert by_name.trace_sha256 == by_default.trace_sha256 == by_scenario.trace_sha256


def test_a_scenario_that_names_its_engine_is_refused_on_the_other(engine: str) -> None:
    other = next(name for name in PHYSICS if name not in ("physics", engine))
    with pytest.raises(ScenarioError, match=f"'{engine}' contradicts the backend, which runs on '{other}'"):
        run(other, engine=engine)
    with pytest.raises(ScenarioError, match="contradicts the backend"):
        run(f"colonysim.backends.{other}:{other.capitalize()}", engine=engine)
    with pytest.raises(ScenarioError, match="contradicts the backend"):
        list(colonysim.simulate(place({**LANE, "physics": {"engine": engine}}), backend=Physics(engine=other)))
    with pytest.raises(ScenarioError, match="contradicts the backend"):
        make_backend("physics", {"engine": other}, place({**LANE, "physics": {"engine": engine}}))
    scenario = place({**LANE, "physics": {"engine": engine}})
    assert colonysim.run(scenario, episodes=1, trace=False).manifest["backend"] == "nodeworld"


def test_an_unknown_engine_is_answered_with_the_nearest(engine: str) -> None:
    with pytest.raises(ScenarioError, match=r"physics\.engine"):
        run("physics", engine="bulet")
    with pytest.raises(ColonysimError, match=r"no engine 'bulet'; did you mean 'bullet'\?"):
        make_backend("physics", {"engine": "bulet"})


def test_an_engine_that_is_missing_is_told_when_the_scenario_asks_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("colonysim.physics.engine.importlib.util.find_spec", lambda name: None)
    for name in ("bullet", "mujoco"):
        with pytest.raises(MissingExtraError, match=re.escape(install_command(name))):
            run("physics", engine=name)
