"""Log of boxes pushed along random ways (sequences of nodes) in cramped surroundings.

It holds of each push what was foreseen and what came of it: the data that the chance of a way is fitted to.
"""

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from colonysim.errors import ColonysimError
from colonysim.files import alone, replace_file
from colonysim.jsonlines import append_line, numbered, warn_of
from colonysim.learning.cards import load_model
from colonysim.learning.seeds import Purpose, episode_rng
from colonysim.physics import Scene, default_engine
from colonysim.push.executors import Executor, make_executor
from colonysim.push.feasibility import load_feasibility
from colonysim.push.foresight import Features, foresee
from colonysim.push.gated import Gate, chance_of_push
from colonysim.push.paths import Surroundings, everything_else
from colonysim.push.task import run_alone
from colonysim.push.training.cramped import CrampedWay, draw_way

__all__ = ["LoggedPush", "LoggedWay", "gather_ways", "push_way"]

_MOST_BYTES = 64 * 2**20
"""Largest log; a way takes some two kilobytes."""
_SHOVED = 0.1
"""A push that moves another box further than this has failed, metres."""


@dataclass(frozen=True, slots=True)
class LoggedPush:
    """A push that was carried out.

    Attributes:
        seen: Its features right before it began.
        forest: What the paper's classifier said right before it began.
        success: Whether the box arrived and no other box was shoved.
        reason: `"done"`, `"box shoved"`, or the executor's reason.
        seconds: Simulated seconds it took.
    """

    seen: Features
    forest: float
    success: bool
    reason: str
    seconds: float


@dataclass(frozen=True, slots=True)
class LoggedWay:
    """What was logged of one box on its way, to the last node or to its first push that failed.

    Attributes:
        foreseen: Features of all its pushes before the first one.
        pushes: Those that were begun.
    """

    foreseen: tuple[Features, ...]
    pushes: tuple[LoggedPush, ...]

    @property
    def success(self) -> bool:
        """Whether all pushes succeeded."""
        return len(self.pushes) == len(self.foreseen) and self.pushes[-1].success


def push_way(
    way: CrampedWay, executor: Executor, forest: Gate, *, seed: int = 0, engine: str | None = None
) -> LoggedWay:
    """Push a box along its way until a push fails.

    Args:
        way: The way and its surroundings.
        executor: What pushes.
        forest: The paper's classifier; it is asked, nobody listens.
        seed: For the executor's drawn choices.
        engine: The rigid-body engine; by default the first that is installed.
    """
    pushes: list[LoggedPush] = []
    with way.scene(engine) as scene:
        obstacles = everything_else(scene, 0)

        def around() -> Surroundings:
            seen = obstacles()
            return Surroundings((), seen.boxes, seen.open_pits)

        foreseen = tuple(foresee(scene, 0, way.tasks, around()))
        for number, task in enumerate(way.tasks):
            seen = next(foresee(scene, 0, [task], around()))
            chance = chance_of_push(scene, 0, task, forest, around())
            before = _others(scene)
            result = run_alone(scene, 0, executor(scene, 0, task, obstacles, seed=seed + number))
            shoved = any(math.dist(a, b) > _SHOVED for a, b in zip(before, _others(scene), strict=True))
            reason = "box shoved" if shoved and result.success else result.reason
            pushes.append(LoggedPush(seen, chance, result.success and not shoved, reason, result.seconds))
            if not pushes[-1].success:
                break
    return LoggedWay(foreseen, tuple(pushes))


def _others(scene: Scene) -> list[Sequence[float]]:
    return [scene.box(i)[:2] for i in range(1, len(scene.boxes))]


def gather_ways(
    file: Path,
    seed: int,
    *,
    model: str | Path = "push",
    ways: int = 600,
    engine: str | None = None,
    on_progress: Callable[[int, int], None] | None = None,
) -> list[LoggedWay]:
    """Push boxes along random ways with the executor `staged`, a line of JSON each; goes on where a file ends.

    Args:
        file: Where the log is kept; its folder is created.
        seed: Makes the ways, apart from the episodes of training, tuning and judging.
        model: The network that pushes.
        ways: How many ways there shall be.
        engine: The rigid-body engine; by default the first that is installed.
        on_progress: Called after each way with the ways so far and their wanted number.

    Raises:
        ColonysimError: The file holds something else, or ways that another seed or network made.
    """
    executor, forest = make_executor("staged", model=model), load_feasibility()
    engine = engine or default_engine()
    made_by = {
        "seed": seed,
        "engine": engine,
        "network": str(load_model(model, "q-network").card["sha256"]),
    }
    with alone(file.parent, "is gathering ways there"):
        logged = _read(file, made_by) if file.exists() else {}
        if not logged:
            replace_file(file, (json.dumps(made_by) + "\n").encode())
        for number in range(ways):
            if number not in logged:
                rng = episode_rng(Purpose.WAYS, seed, number)
                logged[number] = push_way(draw_way(rng), executor, forest, seed=int(rng.integers(2**31)), engine=engine)
                append_line(file, {"number": number, **asdict(logged[number])})
                if on_progress is not None:
                    on_progress(len(logged), ways)
    return [logged[number] for number in range(ways)]


def _read(file: Path, made_by: dict[str, Any]) -> dict[int, LoggedWay]:
    """Ways by number; one whose line is damaged is left out, and named in a warning."""
    logged: dict[int, LoggedWay] = {}
    faults: dict[int, str] = {}
    content = file.read_bytes()
    if not content.endswith(b"\n"):
        replace_file(file, content[: content.rfind(b"\n") + 1])  # it was stopped in the middle of a line
    lines = numbered(file)
    _, header, fault = next(lines, (1, {}, "it is missing"))
    if fault or header != made_by:
        raise ColonysimError(
            f"{file}:1: holds no ways of this seed, engine and network; expected {json.dumps(made_by)}, or choose "
            "another directory"
        )
    for line, row, fault in lines:
        try:
            # Before ways had a number, theirs was that of the line.
            number, way = row.get("number", line - 2), None if fault else _way(row)
        except (ValueError, TypeError, KeyError, AttributeError) as error:
            number, way, fault = None, None, f"it is no logged way: {error}"
        if way is None or not isinstance(number, int):
            faults[line] = fault or "it has no number"
        elif number in logged:
            faults[line] = f"way {number} is there twice"
        else:
            logged[number] = way
    warn_of(file, faults, "these ways are pushed again, the others hold")
    return logged


def _way(row: dict[str, Any]) -> LoggedWay:
    pushes = [LoggedPush(**{**push, "seen": _features(push["seen"])}) for push in row["pushes"]]
    for push in pushes:
        if not (isinstance(push.success, bool) and isinstance(push.reason, str)):
            raise TypeError("expected of a push whether it succeeded, and why")
        _ = float(push.forest), float(push.seconds)
    if not pushes:
        raise ValueError("expected a push")
    return LoggedWay(tuple(_features(seen) for seen in row["foreseen"]), tuple(pushes))


def _features(values: list[float]) -> Features:
    if not all(isinstance(value, (int, float)) for value in values):
        raise TypeError("expected numbers")
    return Features(*values)
