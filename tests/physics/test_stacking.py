"""A small version of `benchmarks/stacking.py`."""

import importlib.util
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.usefixtures("engine")

BENCHMARK = Path(__file__).parents[2] / "benchmarks" / "stacking.py"


@pytest.fixture(scope="module")
def stacking():
    spec = importlib.util.spec_from_file_location("stacking_benchmark", BENCHMARK)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("seed", [900, 901, 902])
def test_two_boxes_fill_a_pit_two_deep_and_carry_the_robot(stacking, seed):
    trial = stacking.run_trial(seed)
    assert trial.success, trial
