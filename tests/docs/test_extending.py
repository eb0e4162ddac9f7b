"""The examples in docs/extending.md run as they stand, one after the other."""

import re
from pathlib import Path

from colonysim.scenario.loading import load_scenario
from colonysim.simulation import simulate

PAGE = Path(__file__).parents[2] / "docs" / "extending.md"


def test_the_examples_run_and_pass_their_checks() -> None:
    names: dict[str, object] = {"__name__": "examples"}
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert len(blocks) == 6
    for block in blocks:
        exec(compile(block, str(PAGE), "exec"), names)
    scenario = load_scenario("easy")
    policy, backend = names["Downhill"], names["Slippery"]
    events = list(simulate(scenario, policy=policy, backend=backend(), episodes=1, seed=1))  # type: ignore[operator,arg-type]
    assert any(event.reason == "slipped" for event in events)
    assert names["COURIER"].trouble() is None  # type: ignore[attr-defined]
