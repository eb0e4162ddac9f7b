"""Agent steps a second of the frameworks that a user might pick instead, beside ours and beside bare SimPy.

The peers are installed from their packages into an environment of their own. Like is compared with like: the same
random walk, in a few lines of Python as a user of each would write it (ours, `OwnWalk`, also looks whether a node is
free, for bodies do not share one). The built-in colony, which reads and leaves all four pheromones, stands beside them.
Every round measures all of them in turn, each in a fresh process, and the yardstick in both environments.

    python benchmarks/peers.py --agents 1000 --side 100 --steps 50 --rounds 3
"""

import argparse
import json
import platform
import random
import statistics
import subprocess
import sys
import time
import venv
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

PACKAGES = ("mesa[network]==3.3.1", "agentpy==0.1.5", "pogema==1.4.0", "simpy")
SEED = 1


def mesa_walk(make: Callable[[random.Random], Any], agents: int, steps: int, crowded: bool) -> float:
    """Walkers in any of Mesa's discrete spaces."""
    import mesa
    from mesa.discrete_space import CellAgent

    class Walker(CellAgent):  # type: ignore[misc]
        cell: Any

        def step(self) -> None:
            self.cell = self.cell.neighborhood.select_random_cell()

    class Model(mesa.Model):  # type: ignore[misc]
        def __init__(self) -> None:
            super().__init__(seed=SEED)
            cells = make(random.Random(SEED)).all_cells
            first = next(iter(cells))
            for _ in range(agents):
                walker = Walker(self)
                walker.cell = first if crowded else cells.select_random_cell()

        def step(self) -> None:
            self.agents.shuffle_do("step")

    return timed(Model().step, steps)


def mesa_grid(agents: int, side: int, steps: int, crowded: bool) -> float:
    from mesa.discrete_space import OrthogonalMooreGrid

    return mesa_walk(lambda draw: OrthogonalMooreGrid((side, side), torus=False, random=draw), agents, steps, crowded)


def mesa_network(agents: int, side: int, steps: int, crowded: bool) -> float:
    import networkx as nx
    from mesa.discrete_space import Network

    graph = nx.convert_node_labels_to_integers(nx.grid_2d_graph(side, side))
    return mesa_walk(lambda draw: Network(graph, random=draw), agents, steps, crowded)


def agentpy_network(agents: int, side: int, steps: int, crowded: bool) -> float:
    import agentpy as ap
    import networkx as nx

    class Walker(ap.Agent):  # type: ignore[misc]
        def step(self) -> None:
            network = self.model.network
            here = network.positions[self]
            network.move_to(self, self.model.random.choice(list(network.graph.neighbors(here))))

    class Model(ap.Model):  # type: ignore[misc]
        def setup(self) -> None:
            graph = nx.convert_node_labels_to_integers(nx.grid_2d_graph(side, side))
            self.network = ap.Network(self, graph)
            walkers = ap.AgentList(self, agents, Walker)
            nodes = list(self.network.nodes)
            places = [nodes[0] if crowded else self.random.choice(nodes) for _ in walkers]
            self.network.add_agents(walkers, places)
            self.walkers = walkers

        def step(self) -> None:
            self.walkers.step()

    model = Model({"seed": SEED})
    model.sim_setup(steps=steps, seed=SEED)
    return timed(model.step, steps)


def pogema_grid(agents: int, side: int, steps: int, crowded: bool) -> float:
    from pogema import GridConfig, pogema_v0

    del crowded  # its agents never share a cell
    # An 11 x 11 view: five cells to each side.
    config = GridConfig(
        num_agents=agents, size=side, density=0.0, obs_radius=5, max_episode_steps=steps + 1, seed=SEED,
        on_target="restart",
    )  # fmt: skip
    env = pogema_v0(config)
    env.reset()
    draw = random.Random(SEED)
    return timed(lambda: env.step([draw.randrange(5) for _ in range(agents)]), steps)


def timed(step: Callable[[], object], steps: int) -> float:
    """Seconds of the steps, after one that warms up."""
    step()
    began = time.perf_counter()
    for _ in range(steps):
        step()
    return time.perf_counter() - began


PEERS: dict[str, Callable[[int, int, int, bool], float]] = {
    "Mesa, grid walk": mesa_grid,
    "Mesa, network walk": mesa_network,
    "AgentPy, network walk": agentpy_network,
    "POGEMA, 11 x 11 view": pogema_grid,
}


OURS = {"colonysim, the same network walk": True, "colonysim, colony": False}
"""Whether it is the random walk."""


def yardstick(processes: int, count: int = 100_000) -> float:
    """Bare SimPy timeouts a second; written out here, as the peers' environment knows nothing of this project."""
    import simpy

    draw = random.Random(SEED)
    each = max(1, count // processes)
    env = simpy.Environment()

    def sleeper() -> Iterator[simpy.Event]:
        for _ in range(each):
            yield env.timeout(0.9 + 0.2 * draw.random())

    for _ in range(processes):
        env.process(sleeper())  # type: ignore[arg-type]
    began = time.perf_counter()
    env.run()
    return each * processes / (time.perf_counter() - began)


def ours(what: str, agents: int, side: int, steps: int, crowded: bool) -> float:
    """Steps a second of our travelling agents: with all four pheromones, or the random walk."""
    from colonysim.bench.brought import OwnWalk
    from colonysim.scenario.invent import invent
    from colonysim.scenario.loading import scenario_from_document
    from colonysim.simulation import simulate

    document = invent("grid", columns=side, rows=side, agents=agents, crowded=crowded, seed=SEED)
    scenario = scenario_from_document({**document, "max_steps": steps})
    policy = OwnWalk if OURS[what] else None
    count = sum(1 for _ in simulate(scenario, policy=policy, episodes=1, seed=SEED, kinds=["end"]))
    began = time.perf_counter()
    for _ in simulate(scenario, policy=policy, episodes=1, seed=SEED, kinds=["episode"]):
        pass
    return count / (time.perf_counter() - began)


def inside(what: str, agents: int, side: int, steps: int, crowded: bool) -> float:
    """One measurement in this process: steps or timeouts a second."""
    if what == "yardstick":
        return yardstick(agents)
    if what in OURS:
        return ours(what, agents, side, steps, crowded)
    return agents * steps / PEERS[what](agents, side, steps, crowded)


def environment(folder: Path) -> str:
    """The interpreter of the peers' environment, made if it is not there."""
    python = folder / ("Scripts/python.exe" if platform.system() == "Windows" else "bin/python")
    if not python.exists():
        venv.create(folder, with_pip=True)
        subprocess.run([python, "-m", "pip", "install", "-q", *PACKAGES], check=True)
    return str(python)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--agents", type=int, nargs="+", default=[1000])
    parser.add_argument("--side", type=int, default=100)
    parser.add_argument("--steps", type=int, default=50)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--crowded", action="store_true", help="all start on one cell, or as close as they may")
    parser.add_argument("--env", type=Path, default=Path("runs/peers-env"), help="where the peers are installed")
    parser.add_argument("--inside", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.inside:
        print(json.dumps(inside(given.inside, given.agents[0], given.side, given.steps, given.crowded)))
        return
    theirs = environment(given.env)

    def measured(python: str, what: str, agents: int) -> float:
        words = [python, __file__, "--inside", what, "--agents", str(agents), "--side", str(given.side)]
        words += ["--steps", str(given.steps), *(["--crowded"] if given.crowded else [])]
        answer = subprocess.run(words, check=True, capture_output=True, text=True).stdout
        return float(json.loads(answer.splitlines()[-1]))

    for agents in given.agents:
        rates: dict[str, list[tuple[float, float]]] = {}
        for _ in range(given.rounds):
            for python, names in ((sys.executable, list(OURS)), (theirs, list(PEERS))):
                for name in names:
                    pair = measured(python, name, agents), measured(python, "yardstick", agents)
                    rates.setdefault(name, []).append(pair)
        start = "all start close together" if given.crowded else "starts spread out"
        print(
            f"\n{agents} agents, {given.side} x {given.side}, {given.steps} steps, {start}; medians of {given.rounds}\n"
        )
        print("| | agent steps/s | of SimPy's timeouts/s |\n|---|---|---|")
        for name, pairs in rates.items():
            rate = statistics.median(r for r, _ in pairs)
            print(f"| {name} | {rate:,.0f} | {statistics.median(r / y for r, y in pairs):.3f} |", flush=True)


if __name__ == "__main__":
    main()
