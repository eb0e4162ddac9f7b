"""Trials in processes of this machine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from colonysim.processes import run_tasks
from colonysim.sweep.trial import run_trial

if TYPE_CHECKING:
    from collections.abc import Generator, Iterable

    from colonysim.sweep.plan import Limits, Trial

__all__ = ["Outcome", "run_locally"]


@dataclass(frozen=True)
class Outcome:
    """What came of a trial.

    Attributes:
        trial: Which one.
        status: "running" when it begins, "succeeded", "failed" or "interrupted" in the end.
        result: What `run_trial` returned, if it succeeded.
        error: The traceback or the reason, if it failed.
        seconds: Of wall clock.
    """

    trial: Trial
    status: Literal["running", "succeeded", "failed", "interrupted"]
    result: dict[str, Any] | None = None
    error: str = ""
    seconds: float = 0.0


def run_locally(trials: Iterable[Trial], limits: Limits, workers: int) -> Generator[Outcome, None, None]:
    """Runs trials in processes of this machine; yields the beginning and the end of each as they come.

    Args:
        trials: In the order in which they are begun.
        limits: What each may take.
        workers: How many run at a time.

    Raises:
        ColonysimError: No processes can be started from the main script.
    """
    reports = run_tasks(run_trial, trials, workers=workers, seconds=limits.seconds, memory_mb=limits.memory_mb)
    try:
        for report in reports:
            yield Outcome(report.task, report.status, report.result, report.error, report.seconds)
    finally:
        reports.close()
