"""Timing one colony beside the yardstick, in a process of its own so that its memory is its own too."""

from __future__ import annotations

import random
import re
import statistics
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from colonysim.arguments import whole
from colonysim.bench.cases import CASES, SEED, Case
from colonysim.errors import ColonysimError
from colonysim.processes import results
from colonysim.recording import run
from colonysim.simulation import simulate
from colonysim.simulation.yardstick import timeouts_per_second
from colonysim.suggest import nearest

if TYPE_CHECKING:
    from colonysim.scenario.scenario import Scenario

__all__ = ["Figures", "measure", "peak_mb"]

TIMEOUTS = 100_000


@dataclass(frozen=True, slots=True)
class Figures:
    """What a case showed.

    Attributes:
        case: Its name.
        agents: How many.
        steps: Steps that were taken, over all agents and episodes of one round.
        decisions: What was decided on: these steps, and waits. Of a traced case only steps are counted.
        build_seconds: Building the scenario.
        seconds: Running it, by round.
        timeouts: The yardstick: bare SimPy timeouts a second with as many processes, by round.
        peak_mb: Largest resident memory of the process that built and ran it once, megabytes; None where the system
            does not tell.
    """

    case: str
    agents: int
    steps: int
    decisions: int
    build_seconds: float
    seconds: tuple[float, ...]
    timeouts: tuple[float, ...]
    peak_mb: float | None

    @property
    def rate(self) -> float:
        """Steps a second, the median of the rounds."""
        return statistics.median(self.steps / taken for taken in self.seconds)

    @property
    def ratio(self) -> float:
        """Steps a second over timeouts a second, the median of the rounds; both of a round were taken in turn."""
        pairs = zip(self.seconds, self.timeouts, strict=True)
        return statistics.median(self.steps / taken / timeouts for taken, timeouts in pairs)

    @property
    def decision_ratio(self) -> float:
        """Decisions a second over timeouts a second: in a crowd most are to wait."""
        return self.ratio * self.decisions / self.steps if self.steps else 0.0


def measure(name: str, rounds: int = 5) -> Figures:
    """Times a case and the yardstick in turn.

    Args:
        name: One of `CASES`.
        rounds: How often; medians are what counts.

    Raises:
        ColonysimError: There is no such case.
    """
    rounds = whole("rounds", rounds)
    if name not in CASES:
        raise ColonysimError(f"no case {name!r}; {nearest(str(name), CASES)}")
    [(_, figures)] = results(_measure, [(name, rounds)], 1)
    return figures  # type: ignore[no-any-return]


def _measure(task: tuple[str, int]) -> Figures:
    name, rounds = task
    case = CASES[name]
    began = time.perf_counter()
    scenario = case.make()
    built = time.perf_counter() - began
    steps, waits, peak = 0, 0, None
    if not case.traced:
        # Counted in a run of its own, which also warms up what is loaded at first use.
        for event in simulate(scenario, kinds=["end", "wait"], **case.settings):
            steps += event.kind == "end"
            waits += event.kind == "wait"
        peak = peak_mb()  # of this one run: what it leaves behind may still be there in the next
    seconds: list[float] = []
    timeouts: list[float] = []
    agents = len(scenario.agents)
    for _ in range(rounds):
        taken, steps = _traced(case, scenario) if case.traced else (_bare(case, scenario), steps)
        peak = peak or peak_mb()  # before the yardstick's own processes
        seconds.append(taken)
        timeouts.append(timeouts_per_second(agents, max(TIMEOUTS, 2 * agents), random.Random(SEED)))
    return Figures(name, agents, steps, steps + waits, built, tuple(seconds), tuple(timeouts), peak)


def peak_mb() -> float | None:
    """Largest resident memory of this process so far, megabytes."""
    if sys.platform == "win32":
        return None
    status = Path("/proc/self/status")
    # Where there is none, `resource` tells, whose figure begins with the memory of whoever started this process.
    if status.exists() and (found := re.search(r"VmHWM:\s*(\d+) kB", status.read_text())):
        return int(found[1]) / 2**10
    import resource

    # macOS counts in bytes, others in kilobytes.
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10)


def _bare(case: Case, scenario: Scenario) -> float:
    """Seconds of the episodes when nobody asks for more than how they ended."""
    began = time.perf_counter()
    for _ in simulate(scenario, kinds=["episode"], **case.settings):
        pass
    return time.perf_counter() - began


def _traced(case: Case, scenario: Scenario) -> tuple[float, int]:
    """Seconds of a recorded run, and its steps."""
    with tempfile.TemporaryDirectory() as folder:
        began = time.perf_counter()
        done = run(scenario, out=Path(folder) / "run", **case.settings)
        taken = time.perf_counter() - began
        steps: int = done.manifest["rows"]["decisions"]
    return taken, steps
