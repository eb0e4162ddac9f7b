"""Extra fields that the stigmergic policy weighs, as a scenario says."""

from __future__ import annotations

import pytest
from small_worlds import SCENT, Scent, place, play

from colonysim.errors import ColonysimError


def diamond(**policy):
    """Two ways to the goal, of the same length: over 1 or over 2."""
    points = [(0.0, 0.0), (1.0, 1.0), (1.0, -1.0), (2.0, 0.0)]
    edges = [(0, 1), (0, 2), (1, 3), (2, 3)]
    return place(points, edges, goal=3, agents=[0], parameters={"extra_fields": [SCENT], **policy})


def share_over_1(scenario, **options):
    events, _ = play(scenario, episodes=60, seed=1, **options)
    first = [e.target for e in events if e.kind == "end" and e.node == 0 and e.step == 1]
    return first.count(1) / len(first)


@pytest.mark.parametrize("epsilon", [0.0, 1.0])
def test_what_is_weighed_draws_or_repels(epsilon):
    """As far as D and as far as E: exploring agents heed it too."""
    more = {"epsilon": epsilon, "epsilon_floor": epsilon}
    assert 0.2 < share_over_1(diamond(**more)) < 0.8
    assert share_over_1(diamond(weights={"A": 3.0}, **more)) > 0.9
    assert share_over_1(diamond(weights={"A": -3.0}, **more)) < 0.1


def test_no_weight_is_a_weight_of_0():
    plain, zero = (play(scenario, episodes=5, seed=2)[0] for scenario in (diamond(), diamond(weights={"A": 0.0})))
    assert plain == zero


@pytest.mark.parametrize(
    ("weights", "words"),
    [({"E": 1.0}, r"policy\.weights\.E: no extra field 'E'; there are: A"), ({"a": 1.0}, "did you mean 'A'"),
     ({"A": "much"}, r"policy\.weights"), ({"A": float("nan")}, r"policy\.weights"), ([1.0], r"policy\.weights")],
)  # fmt: skip
def test_weights_that_cannot_be(weights, words):
    with pytest.raises(ColonysimError, match=words):
        play(diamond(weights=weights), episodes=1)


class Boxed(Scent):
    by_box = True


def test_values_of_boxes_cannot_be_weighed():
    scenario = diamond(extra_fields=[f"{__name__}:Boxed"], weights={"A": 1.0})
    with pytest.raises(ColonysimError, match=r"policy\.weights\.A: the values of 'A' belong to boxes"):
        play(scenario, episodes=1)
