"""Decisions a second of a random policy: by itself, through an AEC environment, and through a parallel one.

    python benchmarks/environments.py hard --rounds 7

The policy is `random` natively, and in the environments a choice among the allowed actions, from full observations.
Times are the processor's; the rounds of the three alternate, and the ratios are the medians of those within a round.
"""

import argparse
import random
import statistics
import time
from collections.abc import Callable

import colonysim
from colonysim import rl
from colonysim.policies.uniform import Uniform

EPISODES = 10


class Counted(Uniform):
    """The random policy, and how often it was asked."""

    name = "counted"
    asked = 0

    def decide(self, view, memory, random):
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


def reset_milliseconds(scenario: colonysim.Scenario, times: int = 200) -> float:
    env = rl.aec(scenario)
    env.reset(seed=1)
    began = time.process_time()
    for _ in range(times):
        env.reset()
    took = time.process_time() - began
    env.close()
    return 1000.0 * took / times


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario", nargs="?", default="hard")
    parser.add_argument("--rounds", type=int, default=7)
    asked = parser.parse_args()
    scenario = colonysim.load_scenario(asked.scenario)
    plays: dict[str, Callable[[colonysim.Scenario], int]] = {
        "native": native, "aec": through_aec, "parallel": through_parallel,
    }  # fmt: skip
    speeds: dict[str, list[float]] = {name: [] for name in plays}
    for play in plays.values():
        play(scenario)
    for _ in range(asked.rounds):
        for name, play in plays.items():
            began = time.process_time()
            count = play(scenario)
            speeds[name].append(count / (time.process_time() - began))
    for name, found in speeds.items():
        ratios = [one / other for one, other in zip(found, speeds["native"], strict=True)]
        print(
            f"{name:9} {statistics.median(found):8.0f} decisions a second, {statistics.median(ratios):.2f} of native "
            f"({min(ratios):.2f} to {max(ratios):.2f})"
        )
    print(f"reset     {reset_milliseconds(scenario):8.2f} ms")


if __name__ == "__main__":
    main()
