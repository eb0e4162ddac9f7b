"""Sweeps: many runs of many settings, which survive whatever happens to them.

`plan` reads a sweep file into trials, `trial` runs one, `workers` runs many in processes of their own, `store` keeps
what came of each, `tables` turns that into tables. `run_sweep` puts them together, of all trials or of one of n
`shards`, which `merge_shards` joins.
"""

from __future__ import annotations

from colonysim.sweep.futures import fork_run
from colonysim.sweep.merging import merge_shards
from colonysim.sweep.plan import Sweep, Trial, load_sweep, plan_sweep
from colonysim.sweep.running import run_planned, run_sweep
from colonysim.sweep.store import Store

__all__ = [
    "Store", "Sweep", "Trial", "fork_run", "load_sweep", "merge_shards", "plan_sweep", "run_planned", "run_sweep",
]  # fmt: skip
