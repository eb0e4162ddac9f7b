"""Wrong parameters are answered with file, line and the nearest right word."""

from __future__ import annotations

import dataclasses

import pytest

from colonysim import load_scenario
from colonysim.errors import ScenarioError
from colonysim.plugins import make_policy
from colonysim.policies.settings import PRESETS, StigmergySettings, settings_for

HEAD = """\
name: small
nodes: [[0, 0, 0, 0], [1, 1, 0, 0], [2, 2, 0, 0]]
edges: [[0, 1], [1, 2]]
agents: [0]
goal: 2
policy:
"""


@pytest.fixture
def policy_of(tmp_path):
    def load(text: str, **options):
        path = tmp_path / "small.yaml"
        path.write_text(HEAD + "".join(f"  {row}\n" for row in text.splitlines()))
        return make_policy(None, load_scenario(path, **options))

    return load


@pytest.mark.parametrize(("text", "place", "words"), [
    ("preset: paper\nbetta: 2", "small.yaml:8:3: policy.betta", "did you mean 'beta'?"),
    ("hole_evaporatoin: .5", "small.yaml:7:3: policy.hole_evaporatoin", "did you mean 'hole_evaporation'?"),
    ("xyzzy: 1", "small.yaml:7:3: policy.xyzzy", "there are: beta, epsilon"),
    ("beta: -1", "small.yaml:7:3: policy.beta", "greater than or equal to 0, not -1"),
    ("beta: hot", "small.yaml:7:3: policy.beta", "not 'hot'"),
    ("epsilon: 1.5", "small.yaml:7:3: policy.epsilon", "less than or equal to 1, not 1.5"),
    ("d_max: .5", "small.yaml:7:3: policy.d_max", "greater than or equal to 1"),
    ("box_decay: 0", "small.yaml:7:3: policy.box_decay", "greater than 0, not 0"),
    ("tries: 0", "small.yaml:7:3: policy.tries", "greater than or equal to 1"),
    ("patience: 0", "small.yaml:7:3: policy.patience", "greater than or equal to 0.001"),
    ("collision: none", "small.yaml:7:3: policy.collision", "'reservation' or 'two_node', not 'none'"),
    ("distance_rule: lrta*", "small.yaml:7:3: policy.distance_rule", "'lrta' or 'literal', not 'lrta*'"),
    ("preset: papr", "small.yaml:7:3: policy.preset", "no preset 'papr'; did you mean 'paper'?"),
    ("preset: [paper]", "small.yaml:7:3", "no preset ['paper']"),
    ("extra_fields: [1]", "small.yaml:7:3", "policy.extra_fields"),
    ("name: random\nbeta: 2", "small.yaml:8:3: policy.beta", "the policy 'random' has none"),
])  # fmt: skip
def test_where_and_what(policy_of, text, place, words):
    with pytest.raises(ScenarioError) as error:
        policy_of(text)
    assert place in str(error.value)
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_an_override_names_itself(policy_of):
    with pytest.raises(ScenarioError, match=r"--set policy.betta=2.*did you mean 'beta'"):
        policy_of("beta: 1", overrides=["policy.betta=2"])
    with pytest.raises(ScenarioError, match=r"--set policy.beta=-2"):
        policy_of("beta: 1", overrides=["policy.beta=-2"])


def test_presets_are_only_sets_of_values():
    names = {field.name for field in dataclasses.fields(StigmergySettings)}
    assert all(set(values) <= names for values in PRESETS.values())
    scenario = load_scenario("sanity")
    assert settings_for(scenario) == StigmergySettings()
    paper = settings_for(scenario, "paper")
    assert {name: getattr(paper, name) for name in PRESETS["paper"]} == PRESETS["paper"]
    own = load_scenario("sanity", None, {"policy.preset": "paper", "policy.beta": 3, "policy.box_cap": None})
    assert settings_for(own) == dataclasses.replace(paper, beta=3.0)
    assert settings_for(own, "colony", override=True) == StigmergySettings(beta=3.0, box_cap=None)


def test_the_values_of_the_presets():
    """As the README and docs/readings.md print them."""
    colony, paper = StigmergySettings(), StigmergySettings(**PRESETS["paper"])
    assert (colony.beta, paper.beta) == (4.0, 1.0)
    assert (colony.epsilon, colony.epsilon_floor) == (paper.epsilon, paper.epsilon_floor) == (0.2, 0.01)
    assert (colony.epsilon_decay, colony.epsilon_per) == (0.8, "episode")
    assert (paper.epsilon_decay, paper.epsilon_per) == (0.95, "choice")
    assert (colony.box_decay, colony.box_start, colony.box_cap) == (0.95, 2.0, 4.0)
    assert (paper.box_decay, paper.box_start, paper.box_cap) == (0.95, 2.0, None)
    assert colony.d_max == paper.d_max == 1.5
    assert (colony.patience, paper.patience) == (5.0, None)
