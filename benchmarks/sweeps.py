"""What a sweep costs beyond its trials, and whether it survives kills, at full size.

    python benchmarks/sweeps.py overhead --trials 2000
    python benchmarks/sweeps.py kills --trials 400 --kills 50
    python benchmarks/sweeps.py workers --trials 400 --kills 50
    python benchmarks/sweeps.py ray --trials 200

`overhead` runs trials of sanity as a sweep and, in turn, in a bare `multiprocessing.Pool` of as many processes, which
begins cold too and reads the scenario once in each. `kills` kills a sweep with its whole process group at random
moments, resumes it each time, and compares its tables with those of one that was left alone. `workers` kills single
worker processes of a sweep that goes on, and compares likewise. `ray` runs a sweep on a
Ray cluster of two nodes of this machine, kills one half-way, and compares in the same way.
"""

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from functools import cache
from multiprocessing import get_context
from pathlib import Path

import colonysim
from colonysim.sweep import Store, run_sweep
from colonysim.sweep.tables import read_table

NEEDED = 1.15
"""Most times the bare pool's wall time."""


def sweep_file(folder: Path, trials: int, episodes: int) -> Path:
    path = folder / "sweep-file.yaml"
    path.write_text(f"scenarios: [sanity]\nseeds: {{count: {trials}}}\nepisodes: {episodes}\n")
    return path


@cache
def sanity() -> colonysim.Scenario:
    return colonysim.load_scenario("sanity")


def bare_trial(job: tuple[int, int]) -> list[int]:
    seed, episodes = job
    run = colonysim.run(sanity(), episodes=episodes, seed=seed, trace=False)
    return [episode.steps for episode in run.episodes]


def overhead(trials: int, episodes: int, workers: int) -> int:
    with tempfile.TemporaryDirectory() as folder:
        began = time.perf_counter()
        run_sweep(sweep_file(Path(folder), trials, episodes), Path(folder) / "out", workers=workers)
        swept = time.perf_counter() - began
    began = time.perf_counter()
    with get_context("spawn").Pool(workers) as pool:
        pool.map(bare_trial, [(seed, episodes) for seed in range(trials)], chunksize=1)
    bare = time.perf_counter() - began
    print(f"{trials} trials of {episodes} episodes, {workers} workers: sweep {swept:.1f} s, bare pool {bare:.1f} s, "
          f"ratio {swept / bare:.3f} (at most {NEEDED})")  # fmt: skip
    return int(swept / bare > NEEDED)


def rows(directory: Path, table: str) -> list[dict[str, object]]:
    found = read_table(directory, table)
    return [{name: value for name, value in row.items() if name != "seconds"} for row in found.to_pylist()]


def same_tables(one: Path, other: Path) -> bool:
    return all(rows(one, table) == rows(other, table) for table in ("trials", "episodes"))


def undisturbed(folder: Path, trials: int, episodes: int, workers: int) -> tuple[Path, Path, list[str]]:
    """Runs a sweep that nothing happens to; where it is, where the other one goes, and the command that runs that."""
    file, whole, out = sweep_file(folder, trials, episodes), folder / "whole", folder / "killed"
    run_sweep(file, whole, workers=workers)
    command = [sys.executable, "-m", "colonysim", "sweep", str(file), "-o", str(out), "-w", str(workers), "-q"]
    return whole, out, command


def finished(directory: Path) -> int:
    journal = directory / "journal.jsonl"
    return journal.read_bytes().count(b'"status":"succeeded"') if journal.exists() else 0


def kills(trials: int, episodes: int, workers: int, times: int) -> int:
    rng, done = random.Random(0), 0
    with tempfile.TemporaryDirectory() as folder:
        whole, out, command = undisturbed(Path(folder), trials, episodes, workers)
        while True:
            process = subprocess.Popen(command, start_new_session=True, stdout=subprocess.DEVNULL)
            if done < times:
                # After up to one and a half times its share of the trials that are left; now and then while it starts.
                there = finished(out)
                share = (trials - there) / (times - done)
                wanted = there + rng.randrange(max(1, round(1.5 * share))) if rng.random() < 0.8 else 0
                while process.poll() is None and finished(out) < wanted:
                    time.sleep(0.005)
                try:
                    process.wait(rng.uniform(0.0, 0.1 if wanted else 1.5))
                except subprocess.TimeoutExpired:
                    os.killpg(process.pid, signal.SIGKILL)
                    done += 1
            if process.wait() == 0:
                break
        lines = (out / "journal.jsonl").read_text().splitlines()
        begun = sum('"status":"running"' in line for line in lines)
        ends = Counter(line[:32] for line in lines if '"status":"succeeded"' in line)
        same = same_tables(out, whole)
        twice = sum(count > 1 for count in ends.values())
        print(f"{trials} trials, {done} kills: tables equal {same}, finished twice {twice}, "
              f"begun again {begun - trials} (at most {workers * done})")  # fmt: skip
        assert len(Store(out).entries) == trials
    return int(not same or twice > 0 or begun - trials > workers * done)


def worker_kills(trials: int, episodes: int, workers: int, times: int) -> int:
    rng, done = random.Random(0), 0
    with tempfile.TemporaryDirectory() as folder:
        whole, out, command = undisturbed(Path(folder), trials, episodes, workers)
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
        while process.poll() is None:
            due = done < times and finished(out) >= trials * done // times
            alive = [child for child in children.read_text().split() if due and is_worker(child)]
            for child in rng.sample(alive, min(1, len(alive))):
                time.sleep(rng.uniform(0.0, 0.1))
                os.kill(int(child), signal.SIGKILL)
                done += 1
            time.sleep(0.005)
        same = same_tables(out, whole)
    print(f"{trials} trials, {done} workers killed: tables equal {same}, exit {process.returncode}")
    return int(not same or process.returncode != 0)


def is_worker(process: str) -> bool:
    return b"spawn_main" in Path(f"/proc/{process}/cmdline").read_bytes()


def on_ray(trials: int, episodes: int) -> int:
    import ray
    from ray.cluster_utils import Cluster

    with tempfile.TemporaryDirectory() as folder:
        file = sweep_file(Path(folder), trials, episodes)
        whole, out = Path(folder) / "whole", Path(folder) / "ray"
        run_sweep(file, whole)
        cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
        node = cluster.add_node(num_cpus=1)
        ray.init(address=cluster.address, log_to_driver=False)
        begun: list[bool] = []
        gone: list[int] = []

        def watch(outcome: object, done: int, total: int) -> None:
            begun.append(getattr(outcome, "status", "") == "running")
            if done >= total // 2 and not gone:
                cluster.remove_node(node, allow_graceful=False)
                gone.append(done)

        run_sweep(file, out, engine="ray", on_outcome=watch)
        ray.shutdown()
        cluster.shutdown()
        same = same_tables(out, whole)
    print(f"{trials} trials on two nodes, one killed after {gone[0]}: tables equal {same}, "
          f"begun again {sum(begun) - trials}")  # fmt: skip
    return int(not same)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("overhead", "kills", "workers", "ray"))
    parser.add_argument("--trials", type=int, default=400)
    parser.add_argument("--episodes", type=int, default=30)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--kills", type=int, default=50)
    asked = parser.parse_args()
    if asked.what == "overhead":
        return overhead(asked.trials, asked.episodes, asked.workers)
    if asked.what == "ray":
        return on_ray(asked.trials, asked.episodes)
    killed = kills if asked.what == "kills" else worker_kills
    return killed(asked.trials, asked.episodes, asked.workers, asked.kills)


if __name__ == "__main__":
    sys.exit(main())
