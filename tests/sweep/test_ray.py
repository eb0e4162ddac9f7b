"""The Ray engine on a cluster of two nodes of this machine, one of which goes away half-way."""

from __future__ import annotations

import os
import socket
from collections import Counter
from pathlib import Path

import pytest

from colonysim.sweep import run_sweep
from colonysim.sweep.tables import read_table

FILE = "scenarios: [sanity]\npolicies: [stigmergy, 'faulty_trials:Raises']\nseeds: {count: 10}\nepisodes: 2\n"


def rows(directory: Path, table: str) -> list[dict[str, object]]:
    found = read_table(directory, table).to_pylist()
    return [{name: value for name, value in row.items() if name not in ("seconds", "error")} for row in found]


def one_processor() -> dict[str, object]:
    """A node's arguments. With ports that are given it need not wait for its agent to choose them."""
    names = ("metrics_agent_port", "metrics_export_port", "runtime_env_agent_port", "dashboard_agent_listen_port")
    sockets = [socket.socket() for _ in names]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = {name: one.getsockname()[1] for name, one in zip(names, sockets, strict=True)}
    for one in sockets:
        one.close()
    return {"num_cpus": 1, "include_dashboard": False, **ports}


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
    cluster = Cluster(initialize_head=True, head_node_args=one_processor())
    try:
        node = cluster.add_node(**one_processor())
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
