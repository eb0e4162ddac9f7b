"""Which trials the studies consist of, as sweeps."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from colonysim.sweep import Sweep, Trial, plan_sweep
from colonysim.sweep.plan import Limits

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

__all__ = [
    "ABLATED",
    "FITTED",
    "FITTED_READINGS",
    "FULL",
    "HARD",
    "MAPS",
    "NEAR",
    "PRESETS",
    "PRESET_POINT",
    "QUICK",
    "Size",
    "ablation",
    "asked",
    "asynchrony",
    "fit",
    "fit_held_out",
    "joined",
    "nodeworld",
    "physics",
]  # fmt: skip

HARD = ("r20-4", "r5-4", "r5-6")
MAPS: tuple[tuple[str, str | None], ...] = (("easy", None), ("medium", None), *(("hard", name) for name in HARD))
"""The rows of the paper's performance tables: map and variant."""
PRESETS = ("paper", "colony")
_LIMITS = Limits(seconds=3600.0)

ABLATED: dict[str, dict[str, tuple[float, ...]]] = {
    "sanity": {
        "policy.epsilon": (0.05, 0.2, 0.5), "policy.epsilon_decay": (0.8, 0.95, 0.99), "detection_radius": (3, 5),
        "policy.beta": (0.5, 1, 2, 4), "policy.box_decay": (0.5, 0.8, 0.95),
    },
    "easy": {
        "policy.epsilon": (0.05, 0.2, 0.5), "policy.epsilon_decay": (0.8, 0.95, 0.99), "detection_radius": (3, 5, 20),
        "policy.beta": (0.5, 1, 2, 4), "policy.box_decay": (0.5, 0.8, 0.95),
    },
}  # fmt: skip
"""The values of the five parameters that are tried; of the paper's own only the two R of sanity are in its text."""


NEAR = (("easy", "policy.epsilon_decay"),)
"""Map and parameter of an ablation whose claim lies so near a limit of the rule that more seeds are wanted."""


@dataclass(frozen=True)
class Size:
    """How much is run, and on which engine.

    Attributes:
        seeds: Seeds of each setting on the node world.
        first_seed: The first of them, and of those in physics.
        episodes: Episodes of a run on the node world.
        physics_seeds: Seeds of each map in physics.
        physics_episodes: Episodes of a run in physics.
        drawn: Seeds of the recorded runs whose pheromones are looked at.
        driven: Episodes of the runs in physics whose trajectories are drawn.
        engine: The rigid-body engine of what is run in physics.
        fit_points: Points of the fit under each of its readings.
        fit_seeds: Seeds of each of them.
        held_out_seeds: Fresh seeds of the best points.
        near_seeds: Seeds of each setting of `NEAR`, if these are more.
    """

    seeds: int = 80
    first_seed: int = 1000
    episodes: int = 30
    physics_seeds: int = 5
    physics_episodes: int = 20
    drawn: int = 40
    driven: int = 10
    engine: str = "bullet"
    fit_points: int = 64
    fit_seeds: int = 4
    held_out_seeds: int = 128
    near_seeds: int = 240

    @property
    def held_out_first(self) -> int:
        """The first of the fresh seeds, far beyond all others."""
        return self.first_seed + 500_000

    def late(self) -> tuple[int, int]:
        """First and last of the episodes after the pheromones have settled on the node world: the last third."""
        return self.episodes - self.episodes // 3 + 1, self.episodes


FULL = Size()
QUICK = replace(
    FULL, seeds=8, physics_seeds=1, physics_episodes=3, drawn=6, driven=4, fit_points=8, fit_seeds=1, held_out_seeds=4,
    near_seeds=0,
)  # fmt: skip

FITTED: dict[str, tuple[float, float]] = {
    "policy.beta": (0.25, 6.0), "policy.epsilon": (0.0, 0.6), "policy.epsilon_decay": (0.8, 1.0),
    "policy.box_decay": (0.5, 1.0), "policy.box_start": (1.0, 4.0),
}  # fmt: skip
"""The parameters without printed values, and the ranges that the fit draws them from."""
FITTED_READINGS: dict[str, tuple[str, ...]] = {
    "policy.collision": ("two_node", "reservation"), "policy.box_credit": ("enter", "leave"),
}  # fmt: skip
"""The two readings that, of `ALTERNATIVES`, bring the preset nearest to the paper's rows by themselves."""
PRESET_POINT: dict[str, Any] = {
    "policy.beta": 1.0, "policy.epsilon": 0.2, "policy.epsilon_decay": 0.95, "policy.box_decay": 0.95,
    "policy.box_start": 2.0, "policy.collision": "two_node", "policy.box_credit": "enter",
}  # fmt: skip
"""The same as the preset `paper` has them."""
ALTERNATIVES: dict[str, Any] = {
    "policy.collision": "reservation", "policy.box_credit": "leave", "policy.patience": 5.0,
    "policy.ask_to_clear": True, "policy.distance_rule": "lrta", "policy.updates": "everywhere",
    "policy.candidates_centre": "agent", "policy.hole_evaporation": 0.5, "policy.epsilon_per": "episode",
    "policy.exploration_evaporation": 0.5, "policy.exploration_on_wait": False, "policy.deposit_at_start": False,
    "policy.overfill": False, "policy.look_on": True, "policy.errands": True,
}  # fmt: skip
"""Readings other than those of the preset `paper`, each tried alone."""


def _document(size: Size, maps: Iterable[tuple[str, str | None]], **more: Any) -> dict[str, Any]:
    chosen = [{"scenario": name, "variants": [variant]} for name, variant in maps]
    seeds = {"count": size.seeds, "first": size.first_seed}
    return {"scenarios": chosen, "policies": list(PRESETS), "seeds": seeds, "episodes": size.episodes, **more}


def nodeworld(size: Size) -> list[dict[str, Any]]:
    """Both presets on all maps, agents acting in their own time as in the paper's physics."""
    return [_document(size, [("sanity", None), *MAPS], modes=["asynchronous"])]


def physics(size: Size) -> list[dict[str, Any]]:
    """Both presets on the paper's maps with rigid bodies, with the paper's push and estimate, and the staged push."""
    body = [
        {"name": size.engine, "push": "rl", "feasibility": "forest"},
        {"name": size.engine, "push": "staged", "feasibility": "way"},
    ]
    seeds = {"count": size.physics_seeds, "first": size.first_seed}
    few = {"seeds": seeds, "episodes": size.physics_episodes}
    return [_document(size, MAPS, modes=["asynchronous"], backends=body) | few]


def ablation(size: Size, name: str) -> list[dict[str, Any]]:
    """One parameter at a time on one map, all agents acting at once as in the paper's node world."""
    near = replace(size, seeds=max(size.seeds, size.near_seeds))
    return [
        _document(
            near if (name, parameter) in NEAR else size, [(name, None)], modes=["synchronous"],
            grid={parameter: list(values)},
        )
        for parameter, values in ABLATED[name].items()
    ]  # fmt: skip


def fit(size: Size) -> list[dict[str, Any]]:
    """The paper's rules on its rows: at many points of `FITTED` under each reading, and each other reading alone.

    beta as the preset has it stands for the preset.
    """
    sample = {"count": size.fit_points, "method": "sobol", "seed": 0, "ranges": {k: list(v) for k, v in FITTED.items()}}
    readings = {name: list(options) for name, options in FITTED_READINGS.items()}
    fitted = _fit(size, size.first_seed, size.fit_seeds)
    alone = [{"grid": {name: [value]}} for name, value in [*ALTERNATIVES.items(), ("policy.beta", 1.0)]]
    return [fitted | {"sample": sample, "grid": readings}, *(fitted | each for each in alone)]


def fit_held_out(size: Size, point: Mapping[str, Any]) -> dict[str, Any]:
    """One point with fresh seeds."""
    grid = {name: [value] for name, value in point.items()}
    return _fit(size, size.held_out_first, size.held_out_seeds) | {"grid": grid}


def _fit(size: Size, first: int, seeds: int) -> dict[str, Any]:
    more = {"policies": ["paper"], "seeds": {"count": seeds, "first": first}, "episodes": FULL.physics_episodes}
    return _document(size, MAPS, modes=["asynchronous"]) | more


def asynchrony(size: Size) -> list[dict[str, Any]]:
    """The same policies in both modes: on the paper's maps, and where colonies can block themselves."""
    both = ["asynchronous", "synchronous"]
    rules = {"policy.collision": ["two_node", "reservation"]}
    return [
        _document(size, MAPS, modes=both),
        _document(size, [("deadlock", None), ("junction", None)], modes=both, grid=rules),
    ]


def asked(documents: Iterable[Mapping[str, Any]]) -> list[Trial]:
    """All trials that some sweeps ask for.

    One may be there under two descriptions: a parameter may be set to what the scenario says anyway.
    """
    return [trial for document in documents for trial in plan_sweep(document).trials]


def joined(trials: Iterable[Trial]) -> Sweep:
    """Trials as one sweep, each once, seed by seed, so that all settings grow together."""
    once = {trial.identity: trial for trial in trials}
    return Sweep("reproduction", tuple(sorted(once.values(), key=lambda trial: trial.seed)), _LIMITS)
