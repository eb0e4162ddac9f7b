"""How well pushes go: single pushes by terrain, and chains of pushes."""

import math
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Protocol

from colonysim.arguments import as_seed, whole
from colonysim.intervals import wilson
from colonysim.learning.seeds import Purpose, episode_rng
from colonysim.physics import Scene
from colonysim.push.choosing import Testing
from colonysim.push.controls import CONTROL_TICKS
from colonysim.push.executors import ChooserName, Executor, ExecutorName, make_executor
from colonysim.push.judging import STEP_LIMIT, STEP_TICKS, Rules, Verdict, judge, reward
from colonysim.push.paths import everything_else
from colonysim.push.state import observe
from colonysim.push.task import Chooser, Kind, Log, Manoeuvre, PushTask, WheelSpeeds, ignore, run_alone
from colonysim.push.training.starts import KINDS, Start, distribution, draw

__all__ = ["Played", "Watch", "evaluate_push", "judged_start", "play_push"]

_REWARDED = Rules(ticks=STEP_TICKS, cross_track_gain=0.0, success_bonus=0.0, failure_penalty=0.0)
"""Paper Eq. 8 for each step of 50 ticks, its heading term held close to the goal."""


@dataclass(frozen=True, slots=True)
class Played:
    """One push that was judged.

    Attributes:
        success: Whether the paper's success conditions were met.
        reason: `"success"`, `"failure"` (paper's table), `"timeout"` (step limit), a fault, or why the
            executor gave up.
        reward: Sum of paper Eq. 8.
        seconds: Simulated seconds.
        network_ticks: Control ticks that the network chose.
        script_ticks: Control ticks that the script chose.
    """

    success: bool
    reason: str
    reward: float
    seconds: float
    network_ticks: int
    script_ticks: int


class Watch(Protocol):
    """Looks on while pushes are evaluated, to record them for instance; it never touches the scene."""

    def begin(self, kind: Kind, number: int) -> None:
        """Push `number` (from 0) on a terrain is about to begin, at `judged_start`."""
        ...

    def tick(self, scene: Scene) -> None:
        """The scene at the start, and after every control tick."""
        ...

    def control(self, chooser: Chooser, control: str, ticks: int) -> None:
        """Someone chose a control, as in `Log`."""
        ...

    def end(self, played: Played) -> None:
        """How the push went."""
        ...


def evaluate_push(
    push: ExecutorName = "staged",
    *,
    episodes: int = 200,
    seed: int = 0,
    terrains: Sequence[Kind] = KINDS,
    chooser: ChooserName = "network",
    model: str | Path | None = None,
    testing: Testing = "greedy",
    ticks: int | None = None,
    tries: int = 8,
    starts: str = "push",
    purpose: Purpose = Purpose.JUDGE,
    engine: str | None = None,
    on_progress: Callable[[Kind, int, int], None] | None = None,
    watch: Watch | None = None,
) -> dict[str, dict[str, Any]]:
    """Success and reward of single pushes from a frozen start distribution, by terrain.

    An episode ends with the paper's success or failure conditions or at its step limit (50 / 100 / 50 steps
    of 50 ticks); whatever an executor does within that time counts, staging and retries included.

    Args:
        push: The executor.
        episodes: Episodes per terrain.
        seed: Makes the episodes; together with `purpose` apart from those of training and tuning.
        terrains: Which terrains.
        chooser: What chooses in the network's place.
        model: The network; None is the shipped one.
        testing: How the network's values become choices.
        ticks: T of the network's actions; None: what it was trained with.
        tries: Tries of `staged` and `scripted`; 1 shows a single push without retries.
        starts: Name of a start distribution.
        purpose: What the episodes are for: never choose anything by looking at `JUDGE`.
        engine: The rigid-body engine; by default the first that is installed.
        on_progress: Called after each episode with the terrain, episodes done, and successes so far.
        watch: Looks on; the results are the same without it.

    Returns:
        For each terrain `episodes`, `success`, `success_low` and `success_high` (Wilson, 95 %), `reward_mean`,
        `reward_sd`, `seconds_mean`, `network_share` (of all control ticks) and `reasons` (counts).

    Raises:
        ModelError: The model is missing or damaged.
        ColonysimError: No episodes, or a setting of the network for `scripted`, which has none.
        ValueError: An unknown name.
    """
    episodes, seed, tries = whole("episodes", episodes), as_seed(seed), whole("tries", tries)
    executor = make_executor(push, model=model, chooser=chooser, testing=testing, ticks=ticks, tries=tries)
    found: dict[str, dict[str, Any]] = {}
    for kind in terrains:
        played: list[Played] = []
        for i in range(episodes):
            start, drawn = judged_start(kind, i, seed=seed, starts=starts, purpose=purpose)
            if watch is None:
                played.append(play_push(start, executor, seed=drawn, engine=engine))
            else:
                watch.begin(kind, i)
                played.append(
                    play_push(start, executor, seed=drawn, log=watch.control, each_tick=watch.tick, engine=engine)
                )
                watch.end(played[-1])
            if on_progress is not None:
                on_progress(kind, i + 1, sum(p.success for p in played))
        found[kind] = _summary(played)
    return found


def judged_start(
    kind: Kind, number: int, *, seed: int, starts: str = "push", purpose: Purpose = Purpose.JUDGE
) -> tuple[Start, int]:
    """Where a push of `evaluate_push` begins, and the seed of its executor.

    Args:
        kind: The terrain.
        number: Which of the terrain's episodes, from 0.
        seed: As there.
        starts: As there.
        purpose: As there.
    """
    rng = episode_rng(purpose, seed, KINDS.index(kind), number)
    return draw(kind, distribution(starts), rng), int(rng.integers(2**32))


def play_push(
    start: Start,
    executor: Executor,
    *,
    seed: int = 0,
    log: Log = ignore,
    each_tick: Callable[[Scene], None] | None = None,
    engine: str | None = None,
) -> Played:
    """Run one push in a fresh scene until it succeeds, fails, or its step limit is reached.

    Args:
        start: Where it begins.
        executor: What pushes.
        seed: For the executor's drawn choices.
        log: Told about every control and who chose it.
        each_tick: Called with the scene at the start and after every tick; it must not change it.
        engine: The rigid-body engine; by default the first that is installed.
    """
    ticks = {"script": 0, "network": 0}

    def count(chooser: Any, control: str, held: int) -> None:
        ticks[chooser] += held
        log(chooser, control, held)

    with start.scene(engine) as scene:
        manoeuvre = executor(scene, 0, start.task, everything_else(scene, 0), count, seed)
        if each_tick is not None:
            each_tick(scene)
        verdict, reason, gained = run_alone(
            scene, 0, _measured(scene, start.task, manoeuvre), each_tick and partial(each_tick, scene)
        )
        return Played(verdict == "success", verdict or reason, gained, scene.time, ticks["network"], ticks["script"])


def _measured(
    scene: Scene, task: PushTask, manoeuvre: Manoeuvre
) -> Generator[WheelSpeeds, None, tuple[Verdict | None, str, float]]:
    """A manoeuvre until it ends, the paper's table has its verdict, or the step limit is reached.

    Returns:
        The table's verdict, why the push ended if there is none, and the sum of paper Eq. 8.
    """
    state = before = observe(scene.robot(0), scene.box(0), task)
    limit = STEP_LIMIT[task.kind] * STEP_TICKS
    gained, reason = 0.0, "timeout"
    verdict: Verdict | None = None
    while scene.ticks < limit:
        try:
            yield next(manoeuvre)
        except StopIteration as end:
            reason = end.value.reason
            state = observe(scene.robot(0), scene.box(0), task)
            verdict = judge(task, state, scene.robot(0), scene.box(0))
            break
        if scene.ticks % CONTROL_TICKS and scene.ticks % STEP_TICKS:
            continue
        state = observe(scene.robot(0), scene.box(0), task)
        verdict = judge(task, state, scene.robot(0), scene.box(0))
        if verdict is not None:
            break
        if scene.ticks % STEP_TICKS == 0:
            if fault := scene.robot_fault(0) or scene.box_fault(0):
                reason = fault
                break
            gained += reward(_REWARDED, before, state, None)
            before = state
    manoeuvre.close()
    return verdict, reason, gained + reward(_REWARDED, before, state, verdict)


def _summary(played: Sequence[Played]) -> dict[str, Any]:
    n = len(played)
    wins = sum(p.success for p in played)
    low, high = wilson(wins, n)
    mean = sum(p.reward for p in played) / n
    spread = math.sqrt(sum((p.reward - mean) ** 2 for p in played) / max(1, n - 1))
    network = sum(p.network_ticks for p in played)
    everything = network + sum(p.script_ticks for p in played)
    reasons: dict[str, int] = {}
    for p in played:
        reasons[p.reason] = reasons.get(p.reason, 0) + 1
    return {
        "episodes": n,
        "success": wins / n,
        "success_low": low,
        "success_high": high,
        "reward_mean": mean,
        "reward_sd": spread,
        "seconds_mean": sum(p.seconds for p in played) / n,
        "network_share": network / everything if everything else 0.0,
        "reasons": reasons,
    }
