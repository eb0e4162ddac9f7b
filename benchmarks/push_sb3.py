"""This package's Double DQN against the DQN of stable-baselines3, at equal actions on the same Gymnasium environment.

Both push from the same starts under the same rules, with three hidden layers of 200, batches of 128, the same discount,
learning rate and replay, one update for every second action, and no demonstrations. stable-baselines3's networks are of
the same form, so both are judged by the same code: the `rl` executor on tuning seeds. The rows:

- `sb3, nine numbers`: the state of paper Eq. 4, which is what the environment gives;
- `sb3, line`: the same in the frame of the push line, which is what this package's networks read;
- `colonysim, nine numbers` and `colonysim, line`: this package's learner, 6-step returns, Boltzmann exploration;
- `colonysim, line, demonstrations`: that with 70 % of the first actions chosen by the demonstrator.

stable-baselines3 is no dependency of this package: `pip install stable-baselines3` where this is run.

    python benchmarks/push_sb3.py --actions 15000 --seeds 0 --out docs/results/push_sb3.jsonl
"""

import argparse
import dataclasses
import time
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

from colonysim.jsonlines import append_line, read_lines, warn_of
from colonysim.learning.cards import save_model
from colonysim.learning.seeds import Purpose
from colonysim.push.network import INPUTS, encode
from colonysim.push.training.env import PushEnv
from colonysim.push.training.evaluation import evaluate_push
from colonysim.push.training.presets import PRESETS, StartMix, TrainingConfig
from colonysim.push.training.trainer import train_push

STARTS = "push_wide"
ROWS = (
    "sb3, nine numbers",
    "sb3, line",
    "colonysim, nine numbers",
    "colonysim, line",
    "colonysim, line, demonstrations",
)


def config_of(row: str, actions: int) -> TrainingConfig:
    """What both learners share, in this package's words; the environment's own terrains and no guards.

    There are no candidates: the network is the last one, as with stable-baselines3.
    """
    base = PRESETS["improved"]
    return dataclasses.replace(
        base, name=row, inputs="line" if "line" in row else "state", actions=actions, explore=1_000,
        demonstrations=0.7 if "demonstrations" in row else 0.0, kinds=PRESETS["paper"].kinds,
        starts=(StartMix(STARTS, 1.0, guards=False),), rules=dataclasses.replace(base.rules, guards=False),
        train_block=10, test_block=1, candidates=0,
    )  # fmt: skip


class Line(gymnasium.ObservationWrapper[Any, Any, Any]):
    """The nine numbers in the frame of the push line."""

    def __init__(self, env: gymnasium.Env[Any, Any]) -> None:
        super().__init__(env)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (INPUTS["line"],), np.float32)

    def observation(self, observation: Any) -> Any:
        """What the network reads."""
        return encode("line", observation)


def train_sb3(config: TrainingConfig, seed: int, folder: Path) -> tuple[Path, float]:
    """Train with stable-baselines3 and keep its network in this package's form; wall seconds of the learning."""
    import torch
    from stable_baselines3 import DQN

    torch.set_num_threads(1)
    env: gymnasium.Env[Any, Any] = PushEnv("mixed", rules=config.rules, starts=STARTS)
    if config.inputs == "line":
        env = Line(env)
    assert config.actions is not None
    model = DQN(
        "MlpPolicy", env, seed=seed, learning_rate=config.learner.learning_rate, gamma=config.gamma,
        buffer_size=config.buffer, batch_size=config.batch, learning_starts=config.explore,
        train_freq=config.update_every, gradient_steps=1, target_update_interval=300, exploration_fraction=0.3,
        exploration_final_eps=config.epsilon_floor, policy_kwargs={"net_arch": list(config.hidden)}, device="cpu",
    )  # fmt: skip
    began = time.perf_counter()
    model.learn(config.actions)
    seconds = time.perf_counter() - began
    env.close()
    linear = [m for m in model.q_net.q_net if isinstance(m, torch.nn.Linear)]
    arrays = {}
    for i, layer in enumerate(linear):
        arrays[f"w{i}"], arrays[f"b{i}"] = layer.weight.detach().numpy(), layer.bias.detach().numpy()
    path = folder / "sb3.npz"
    save_model(path, "q-network", arrays, {"inputs": config.inputs, "ticks": config.rules.ticks})
    return path, seconds


def train_own(config: TrainingConfig, seed: int, folder: Path) -> tuple[Path, float]:
    """Train with this package; wall seconds of the learning, with a test and a checkpoint for every ten episodes."""
    began = time.perf_counter()
    trained = train_push(config, folder, seed)
    assert trained is not None
    return trained.card.with_suffix(".npz"), time.perf_counter() - began


def measure(row: str, actions: int, seed: int, pushes: int, work: Path) -> dict[str, Any]:
    """Train one row, then push."""
    config = config_of(row, actions)
    folder = work / f"{row.replace(', ', '-').replace(' ', '-')}-{actions}-{seed}"
    path, seconds = (train_sb3 if row.startswith("sb3") else train_own)(config, seed, folder)
    found = evaluate_push("rl", episodes=pushes, seed=seed, model=path, purpose=Purpose.TUNE)
    return {
        "row": row, "actions": actions, "seed": seed, "pushes": pushes,
        "actions_per_second": round(actions / seconds, 1),
        "success": {kind: r["success"] for kind, r in found.items()},
    }  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--actions", type=int, default=15_000)
    parser.add_argument("--pushes", type=int, default=100, help="pushes a terrain after each training")
    parser.add_argument("--seeds", type=int, nargs="+", default=[0])
    parser.add_argument("--rows", nargs="+", default=list(ROWS), choices=ROWS)
    parser.add_argument("--work", type=Path, default=Path("runs/push-sb3"))
    parser.add_argument("--out", type=Path, default=Path("docs/results/push_sb3.jsonl"))
    given = parser.parse_args()
    names = {"row", "actions", "seed"}
    rows: list[dict[str, Any]] = []
    faults: dict[int, str] = {}
    if given.out.exists():
        rows, faults = read_lines(given.out, lambda row: None if names <= row.keys() else "no training")
    warn_of(given.out, faults, "these trainings are made again")
    done = {(r["row"], r["actions"], r["seed"]) for r in rows}
    for seed in given.seeds:
        for name in given.rows:
            if (name, given.actions, seed) not in done:
                row = measure(name, given.actions, seed, given.pushes, given.work)
                append_line(given.out, row)
                print(row, flush=True)


if __name__ == "__main__":
    main()
