"""Settings chosen by what came of those before: a sweep whose sample Optuna draws."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from statistics import fmean
from typing import TYPE_CHECKING, Any, Literal

from colonysim.arguments import as_span
from colonysim.errors import ColonysimError, MissingExtraError
from colonysim.installing import install_command
from colonysim.intervals import of_mean
from colonysim.processes import refuse_unguarded
from colonysim.suggest import nearest
from colonysim.sweep.plan import Sweep, load_search
from colonysim.sweep.running import run_planned
from colonysim.sweep.store import Store

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from colonysim.sweep.plan import Trial
    from colonysim.sweep.running import Engine
    from colonysim.sweep.workers import Outcome

__all__ = ["Candidate", "Measure", "tune"]

Measure = Literal["steps", "success", "sim_seconds"]
_COLUMN = {"steps": 1, "success": 2, "sim_seconds": 4}
"""Where a trial's result has each measure of an episode."""


@dataclass(frozen=True)
class Candidate:
    """One choice of settings, and what came of it.

    Attributes:
        settings: By path.
        value: Mean of the measure over its trials; None if one of them failed.
        interval: Its 95 % interval over seeds; None with one seed.
    """

    settings: Mapping[str, float]
    value: float | None
    interval: tuple[float, float] | None


def tune(
    file: str | Path,
    out: str | Path,
    *,
    measure: Measure = "steps",
    episodes: tuple[int, int] | None = None,
    workers: int | None = None,
    engine: Engine = "local",
    on_outcome: Callable[[Outcome, int, int], None] | None = None,
    on_candidate: Callable[[Candidate, int, int], None] | None = None,
) -> list[Candidate]:
    """Looks for settings with few steps, short episodes or much success, by Optuna's tree-structured Parzen estimator.

    The file is a sweep's: `sample` has the ranges, how many choices are tried and the seed of the search. The trials
    of a choice, all scenarios and seeds, run as a sweep in `out`, and what `out` holds is not run again: the search
    may be stopped at any time, goes on where it was, and tries more choices when `count` has grown.

    Args:
        file: The sweep file.
        out: The sweep's directory.
        measure: What is made small, or with "success" large: its mean over episodes, then over trials.
        episodes: First and last episode that count; None for all.
        workers: How many trials run at a time; None: one for each processor.
        engine: As for a sweep.
        on_outcome: Called when a trial begins and when it ends, with how many are done and how many are known.
        on_candidate: Called after each choice, with how many there are and how many there will be.

    Returns:
        All choices, the best first, those that failed last.

    Raises:
        MissingExtraError: Optuna is not installed.
        ColonysimError: The file is wrong, the directory cannot be used, or no trial has the episodes that count.
    """
    refuse_unguarded()
    if measure not in _COLUMN:
        raise ColonysimError(f"no measure {measure!r}; {nearest(str(measure), _COLUMN)}")
    if episodes is not None:
        episodes = as_span("episodes", episodes)
    optuna = _optuna()
    search = load_search(file)
    study = optuna.create_study(
        direction="maximize" if measure == "success" else "minimize",
        sampler=optuna.samplers.TPESampler(seed=search.seed % 2**32),  # it takes 32 bits
    )
    candidates: list[Candidate] = []
    trials: dict[str, Trial] = {}
    with Store(out, write=True) as store:
        for number in range(1, search.count + 1):
            asked = study.ask()
            settings = {name: asked.suggest_float(name, *limits) for name, limits in search.ranges.items()}
            chosen = search.trials(settings)
            trials |= {trial.identity: trial for trial in chosen}
            run_planned(
                Sweep(search.name, tuple(trials.values()), search.limits), store, workers=workers, engine=engine,
                on_outcome=on_outcome, copy_of=Path(file),
            )  # fmt: skip
            candidates.append(_candidate(settings, chosen, store, measure, episodes))
            # The same answers to the same questions: a search that is taken up again asks what it asked before.
            if (value := candidates[-1].value) is None:
                study.tell(asked, state=optuna.trial.TrialState.FAIL)
            else:
                study.tell(asked, value)
            if on_candidate is not None:
                on_candidate(candidates[-1], number, search.count)
    return sorted(candidates, key=lambda found: _rank(found, measure))


def _optuna() -> Any:
    try:
        import optuna
    except ImportError as error:
        raise MissingExtraError(f"tuning needs Optuna ({error}): {install_command('tune')}") from error
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    return optuna


def _candidate(
    settings: Mapping[str, float], trials: Sequence[Trial], store: Store, measure: Measure,
    episodes: tuple[int, int] | None,
) -> Candidate:  # fmt: skip
    by_seed: dict[int, list[float]] = {}
    for trial in trials:
        entry = store.entries[trial.identity]
        if entry["status"] != "succeeded":
            return Candidate(settings, None, None)
        first, last = episodes or (1, len(entry["episodes"]))
        counted = [row[_COLUMN[measure]] for row in entry["episodes"] if first <= row[0] <= last]
        if not counted:
            raise ColonysimError(f"no episode {first}-{last}: a run has {len(entry['episodes'])}")
        by_seed.setdefault(trial.seed, []).append(fmean(counted))
    means = [fmean(values) for values in by_seed.values()]
    return Candidate(settings, fmean(means), of_mean(means, within=(0.0, 1.0) if measure == "success" else None))


def _rank(found: Candidate, measure: Measure) -> tuple[bool, float]:
    if found.value is None:
        return True, 0.0
    return False, -found.value if measure == "success" else found.value
