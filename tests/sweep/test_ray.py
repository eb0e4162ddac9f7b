"""The Ray engine on a cluster of two nodes of this machine, one of which goes away half-way."""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

import pytest

from colonysim.sweep import run_sweep
from colonysim.sweep.tables import read_table

FILE = "scenarios: [sanity]\npolicies: [stigmergy, 'faulty_trials:Raises']\nseeds: {count: 10}\nepisodes: 2\n"


def rows(directory: Path, table: str) -> list[dict[str, object]]:
    found = read_table(directory, table).to_pylist()
    return [{name: value for name, value in row.items() if name not in ("seconds", "error")} for row in found]


def test_a_node_that_goes_away_changes_nothing(tmp_path, monkeypatch):
    # A busy machine takes longer to start a node than Ray waits by default.
    monkeypatch.setenv("RAY_raylet_start_wait_time_s", "120")
    ray = pytest.importorskip("ray", reason="the engine 'ray' needs Ray: pip install 'colonysim[ray]'")
    from ray.cluster_utils import Cluster

    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]))
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    file = tmp_path / "small.yaml"
    file.write_text(FILE)
    run_sweep(file, tmp_path / "local", workers=2)
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    try:
        node = cluster.add_node(num_cpus=1)
        ray.init(address=cluster.address, log_to_driver=False)
        begun: Counter[str] = Counter()
        gone: list[int] = []

        def watch(outcome, done, total):
            begun[outcome.trial.identity] += outcome.status == "running"
            if done >= total // 2 and not gone:
                cluster.remove_node(node, allow_graceful=False)
                gone.append(done)

        run_sweep(file, tmp_path / "ray", engine="ray", on_outcome=watch)
    finally:
        ray.shutdown()
        cluster.shutdown()
    assert gone and len(begun) == 20 and sum(begun.values()) <= 21, "at most what ran there was begun again"
    for table in ("trials", "episodes"):
        assert rows(tmp_path / "ray", table) == rows(tmp_path / "local", table)
    failed = [row for row in read_table(tmp_path / "ray", "trials").to_pylist() if row["status"] == "failed"]
    assert len(failed) == 10 and all("out of ideas" in str(row["error"]) for row in failed)
