"""Rows of results that were stored before, as `benchmarks/physics_tables.py` and `benchmarks/push_ablation.py` do."""

from __future__ import annotations

import json
from collections import Counter
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, model_validator

from colonysim.arguments import MAX_SEED
from colonysim.backends.physics import FEASIBILITIES, SUITED
from colonysim.errors import ColonysimError
from colonysim.jsonlines import described, read_lines
from colonysim.physics import ENGINES
from colonysim.push.task import Kind
from colonysim.push.training.presets import READINGS
from colonysim.reproduce.plans import PRESETS
from colonysim.suggest import nearest

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from pathlib import Path

__all__ = ["ALL_IN_ONE", "OWN", "SETTINGS", "StoredRun", "StoredTraining", "fault_finder", "stored_rows"]

ALL_IN_ONE = "all-in-one"
"""The setting of a training on all terrains."""
OWN = "preset"
"""The setting with a reading's own values of b, S and M, on all terrains."""
SETTINGS = (
    "base", "batch 64", "batch 256", "explore 3000", "explore 5000", "target 600", "target 1200",
    "individual flat", "individual slope", ALL_IN_ONE, OWN,
)  # fmt: skip
"""What trainings are told apart by; `base` is b = 128, S = 1000, M = 300, on holes."""


def _one_of(known: Iterable[str]) -> AfterValidator:
    words = tuple(known)

    def check(word: str) -> str:
        if word not in words:
            raise ValueError(f"{word!r} is not known; {nearest(word, words)}")
        return word

    return AfterValidator(check)


Count = Annotated[int, Field(strict=True, ge=0, le=10**9)]
Seed = Annotated[int, Field(strict=True, ge=0, le=MAX_SEED)]
Number = Annotated[float, Field(strict=True, ge=-1e9, le=1e9, allow_inf_nan=False)]
Share = Annotated[float, Field(strict=True, ge=0.0, le=1.0, allow_inf_nan=False)]
Engine = Annotated[str, _one_of(ENGINES)]
Scalar = Annotated[bool, Field(strict=True)] | Annotated[int, Field(strict=True)] | Number | str | None


Pushed = tuple[Share, Number] | tuple[Share, Number, Number]
"""Success and mean reward of pushes; in newer rows the standard deviation of the reward too."""


class _Row(BaseModel):
    model_config = ConfigDict(frozen=True)


class StoredEpisode(_Row):
    """An episode: its steps, its share of agents at the goal, how it ended, simulated seconds, boxes in their holes."""

    steps: Count
    success: Share
    ended: str
    sim_seconds: Annotated[Number, Field(ge=0.0)]
    seated: Count


class StoredRun(_Row):
    """A run in physics.

    A row that names no engine is of Bullet, one that names no policy of `colony`; one that names no estimate has that
    which suits the executor.
    """

    map: str
    push: Annotated[str, _one_of(SUITED)]
    seed: Seed
    episodes: Annotated[list[StoredEpisode], Field(min_length=1)]
    engine: Engine = "bullet"
    policy: Annotated[str, _one_of(PRESETS)] = "colony"
    feasibility: Annotated[str, _one_of(FEASIBILITIES)] = ""
    parameters: dict[str, Scalar] = {}

    @model_validator(mode="before")
    @classmethod
    def _suited(cls, row: Any) -> Any:
        if isinstance(row, dict) and "feasibility" not in row and isinstance(row.get("push"), str):
            return {**row, "feasibility": SUITED.get(row["push"], "")}
        return row

    @property
    def place(self) -> tuple[str, str | None]:
        """Scenario and variant, as the paper's table has them."""
        name, _, variant = self.map.partition(":")
        return name, variant or ("r20-4" if name == "hard" else None)

    @property
    def identity(self) -> tuple[str, ...]:
        """What no other row of a file may have."""
        parameters = json.dumps(self.parameters, sort_keys=True) if self.parameters else ""
        return self.engine, ":".join(filter(None, self.place)), self.policy, self.push, self.feasibility, parameters, \
            str(self.seed)  # fmt: skip

    @property
    def length(self) -> int:
        """Episodes."""
        return len(self.episodes)


class StoredTraining(_Row):
    """A training of the push, and what its networks then did.

    `tests` holds for each block of tests the training episodes and actions before it, its success and its mean reward;
    `pushed` and `pushed_last` hold by terrain the success and the mean reward of the best and of the last network.
    """

    setting: Annotated[str, _one_of(SETTINGS)]
    base: Annotated[str, _one_of(READINGS)]
    episodes: Annotated[Count, Field(ge=1)]
    seed: Seed
    peak_episode: Annotated[int, Field(strict=True, ge=-(10**9), le=10**9)]
    tests: Annotated[list[tuple[Count, Count, Share, Number]], Field(min_length=1)]
    pushed: dict[Kind, Pushed]
    pushed_last: dict[Kind, Pushed] = {}
    pushes: Annotated[Count, Field(ge=1)]
    losses: list[Number] = []
    engine: Engine = "bullet"

    @property
    def identity(self) -> tuple[str, ...]:
        """What no other row of a file may have."""
        return self.base, self.engine, self.setting, str(self.episodes), str(self.seed)

    @property
    def length(self) -> int:
        """Training episodes."""
        return self.episodes


_Stored = TypeVar("_Stored", StoredRun, StoredTraining)


def fault_finder(form: type[StoredRun] | type[StoredTraining]) -> Callable[[dict[str, Any]], str | None]:
    """A function that tells what is wrong with a row, or that an earlier one is the same: for `read_lines`."""
    seen: set[tuple[str, ...]] = set()

    def fault_of(line: dict[str, Any]) -> str | None:
        try:
            row = form.model_validate(line)
        except ValidationError as error:
            return _told(error)
        if row.identity in seen:
            return f"it is there twice ({', '.join(filter(None, row.identity))})"
        seen.add(row.identity)
        return None

    return fault_of


def stored_rows(path: Path, form: type[_Stored]) -> tuple[list[_Stored], list[str]]:
    """The rows of a file of results, and what was left out of it and why: a line for each reason.

    Rows count that are whole, there for the first time, and of the usual length: the one that most have, of several
    such the longest.

    Raises:
        ColonysimError: The file cannot be read, or no line of it is such a row.
    """
    lines, faults = read_lines(path, fault_finder(form))
    rows = [form.model_validate(line) for line in lines]
    if not rows:
        what, script = _MADE_BY[form]
        why = described(path, faults) if faults else f"{path}: it is empty"
        raise ColonysimError(f"{path}: not {what} as {script} stores them: {why}")
    counts = Counter(row.length for row in rows)
    usual = max(counts, key=lambda length: (counts[length], length))
    gaps = [f"{described(path, faults)}; left out"] if faults else []
    if others := counts.total() - counts[usual]:
        gaps.append(f"{path}: {others} of {counts.total()} rows have other than {usual} episodes; left out")
    return [row for row in rows if row.length == usual], gaps


_MADE_BY: dict[type, tuple[str, str]] = {
    StoredRun: ("runs in physics", "benchmarks/physics_tables.py"),
    StoredTraining: ("trainings", "benchmarks/push_ablation.py"),
}


def _told(error: ValidationError) -> str:
    """The first thing that is wrong with a row."""
    first = error.errors(include_url=False, include_context=False, include_input=False)[0]
    says = str(first["msg"]).removeprefix("Value error, ")
    if not first["loc"]:
        return says
    name, *inner = (str(part) for part in first["loc"])
    where = f"{name!r}" + (f" ({'.'.join(inner)})" if inner else "")
    return f"its {where} is missing" if first["type"] == "missing" else f"its {where}: {says}"
