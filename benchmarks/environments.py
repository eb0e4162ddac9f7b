"""Decisions a second of a random policy: natively, through this package's environments, and in those of others.

    python benchmarks/environments.py hard --rounds 7
    pip install mpe2 rware  # the others, which nothing here needs

The policy is `random` natively, and in the environments a choice among the allowed actions, from full observations.
Of the others all actions are allowed: `simple_spread` of the Multi Particle Environments (`mpe2`), through AEC and
parallel, and RWARE's `tiny` warehouse (`rware`), which has a parallel form only; each with as many agents as the
scenario, and for as many steps as it has by default. Those that are not installed are left out and named.
Times are the processor's; the rounds of all alternate, and the ratios are the medians of those within a round.
"""

import argparse
import random
import statistics
import time
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

import colonysim
from colonysim import rl
from colonysim.policies.policy import Choice
from colonysim.policies.uniform import Uniform
from colonysim.policies.view import LocalView

EPISODES = 10


class Counted(Uniform):
    """The random policy, and how often it was asked."""

    name = "counted"
    asked = 0

    def decide(self, view: LocalView, memory: None, random: random.Random) -> Choice:
        Counted.asked += 1
        return super().decide(view, memory, random)


def native(scenario: colonysim.Scenario) -> int:
    Counted.asked = 0
    with colonysim.Colony(scenario, policy=Counted, episodes=EPISODES, seed=1, kinds=("episode",)) as colony:
        for _ in colony:
            pass
    return Counted.asked


def drawn(mask: list[int], moves: int, stream: random.Random) -> int:
    """A move that is allowed, or a wait."""
    allowed = [action for action in range(moves) if mask[action]] or [moves]
    return allowed[int(stream.random() * len(allowed))]


def through_aec(scenario: colonysim.Scenario) -> int:
    env, asked, stream = rl.aec(scenario, policy="random", seed=1), 0, random.Random(1)
    moves = env.turns.observer.moves.wait
    for _ in range(EPISODES):
        env.reset()
        for _ in env.agent_iter():
            _, _, terminated, truncated, info = env.last()
            if terminated or truncated:
                env.step(None)
            else:
                env.step(drawn(info["action_mask"].tolist(), moves, stream))
                asked += 1
    env.close()
    return asked


def through_parallel(scenario: colonysim.Scenario) -> int:
    env, asked, stream = rl.parallel(scenario, policy="random", seed=1), 0, random.Random(1)
    moves = env.turns.observer.moves.wait
    for _ in range(EPISODES):
        _, infos = env.reset()
        while env.agents:
            actions = {
                agent: drawn(infos[agent]["action_mask"].tolist(), moves, stream)
                for agent in env.agents
                if infos[agent]["requires_decision"]
            }
            asked += len(actions)
            *_, infos = env.step(actions)
    env.close()
    return asked


def spread_aec(scenario: colonysim.Scenario) -> int:
    from mpe2 import simple_spread_v3

    env, asked, stream = simple_spread_v3.env(N=len(scenario.agents)), 0, random.Random(1)
    for episode in range(EPISODES):
        env.reset(seed=episode)
        for agent in env.agent_iter():
            _, _, terminated, truncated, _ = env.last()
            if terminated or truncated:
                env.step(None)
            else:
                env.step(int(stream.random() * env.action_space(agent).n))
                asked += 1
    env.close()
    return asked


def spread_parallel(scenario: colonysim.Scenario) -> int:
    from mpe2 import simple_spread_v3

    env, asked, stream = simple_spread_v3.parallel_env(N=len(scenario.agents)), 0, random.Random(1)
    for episode in range(EPISODES):
        env.reset(seed=episode)
        while env.agents:
            actions = {agent: int(stream.random() * env.action_space(agent).n) for agent in env.agents}
            asked += len(actions)
            env.step(actions)
    env.close()
    return asked


def warehouse(scenario: colonysim.Scenario) -> int:
    import gymnasium
    import rware  # noqa: F401  # registers them

    agents, asked, stream = len(scenario.agents), 0, random.Random(1)
    env = gymnasium.make("rware-tiny-2ag-v2", n_agents=agents, disable_env_checker=True).unwrapped
    spaces: Any = env.action_space
    moves = [space.n for space in spaces]
    env.reset(seed=1)
    over = False
    while not over:
        _, _, over, truncated, _ = env.step([int(stream.random() * each) for each in moves])
        over, asked = over or truncated, asked + agents
    env.close()
    return asked


OURS: dict[str, Callable[[colonysim.Scenario], int]] = {
    "native": native, "aec": through_aec, "parallel": through_parallel,
}  # fmt: skip
OTHERS: dict[str, tuple[str, Callable[[colonysim.Scenario], int]]] = {
    "simple_spread, aec": ("mpe2", spread_aec), "simple_spread, parallel": ("mpe2", spread_parallel),
    "rware-tiny": ("rware", warehouse),
}  # fmt: skip
"""Environments of others, and the package of each."""


def installed(scenario: colonysim.Scenario) -> dict[str, Callable[[colonysim.Scenario], int]]:
    """All that can be timed here, each having run once; the others are told."""
    plays = dict(OURS)
    for name, (package, play) in OTHERS.items():
        try:
            play(scenario)
        except ModuleNotFoundError as error:
            print(f"{name}: left out, {error.name} is not installed (pip install {package})")
        else:
            plays[name] = play
    for play in OURS.values():
        play(scenario)
    return plays


def reset_milliseconds(scenario: colonysim.Scenario, times: int = 200) -> np.ndarray[Any, Any]:
    """What a reset takes, each."""
    env, took = rl.aec(scenario), []
    env.reset(seed=1)
    for _ in range(times):
        began = time.process_time()
        env.reset()
        took.append(1000.0 * (time.process_time() - began))
    env.close()
    return np.array(took)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario", nargs="?", default="hard")
    parser.add_argument("--rounds", type=int, default=7)
    asked = parser.parse_args()
    warnings.filterwarnings("ignore", module="gymnasium|pettingzoo")  # what they advise the others of
    scenario = colonysim.load_scenario(asked.scenario)
    plays = installed(scenario)
    speeds: dict[str, list[float]] = {name: [] for name in plays}
    for _ in range(asked.rounds):
        for name, play in plays.items():
            began = time.process_time()
            count = play(scenario)
            speeds[name].append(count / (time.process_time() - began))
    print(f"{scenario.name}, {len(scenario.agents)} agents, {asked.rounds} rounds; decisions a second by the median,")
    print("and how many times those of the native policy (least to greatest)")
    for name, found in speeds.items():
        ratios = [one / other for one, other in zip(found, speeds["native"], strict=True)]
        print(
            f"{name:24} {statistics.median(found):8.0f} {statistics.median(ratios):6.2f} "
            f"({min(ratios):.2f} to {max(ratios):.2f})"
        )
    took = reset_milliseconds(scenario)
    print(f"reset: {np.median(took):.2f} ms by the median of {len(took)}, {np.quantile(took, 0.95):.2f} ms at 95 %")


if __name__ == "__main__":
    main()
