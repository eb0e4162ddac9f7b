"""Proximal policy optimisation with one network for all agents, discounted by simulated time (IPPO and MAPPO)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import torch
from torch import nn

from colonysim.rl.training.games import SUMMARY, Decided
from colonysim.rl.training.network import Columns, Scorer, symmetries

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from typing import Any

    from numpy.typing import NDArray

    from colonysim.rl.training.games import Game, Path
    from colonysim.rl.training.imitation import Lessons
    from colonysim.rl.training.presets import PolicyConfig

__all__ = ["Batch", "Learner", "advantages"]

FORBIDDEN = -1e9
"""Logit of an action that is not allowed."""


def advantages(path: Path, values: Sequence[float], trace_decay: float) -> list[float]:
    """The generalised advantage of each decision of an agent, with the discount of the time that passed after it.

    With r paid until the next decision, d the discount of the time until then, V what the critic expects and L the
    trace's decay: A = r + d V(next) - V + d L A(next); after the last decision d is 0.

    Args:
        path: The agent's decisions.
        values: V of each of them.
        trace_decay: L.
    """
    found, following, value = [0.0] * len(path.action), 0.0, 0.0
    for i in reversed(range(len(path.action))):
        following = path.reward[i] + path.discount[i] * (value + trace_decay * following) - values[i]
        value, found[i] = values[i], following
    return found


@dataclass(frozen=True, slots=True)
class Batch:
    """Decisions to learn from.

    Attributes:
        told: Shape (n, numbers).
        more: What the critic is told besides, shape (n, 0) or (n, `SUMMARY`).
        mask: Shape (n, actions), true where allowed.
        action: Shape (n,).
        chance: Logarithm of the chance with which it was chosen, shape (n,).
        advantage: Shape (n,), with mean 0 and standard deviation 1.
        returned: What the critic should have expected, shape (n,).
    """

    told: torch.Tensor
    more: torch.Tensor
    mask: torch.Tensor
    action: torch.Tensor
    chance: torch.Tensor
    advantage: torch.Tensor
    returned: torch.Tensor


class Learner:
    """The policy and the critic, and the optimizers that move them.

    Args:
        options: As of `Observer.options`.
        config: The training's parameters.
        seed: Makes the first weights.

    Attributes:
        config: The parameters.
        policy: Gives the logits of all actions.
        critic: Gives the return that is to be expected.
        symmetries: The ways to turn and mirror what agents are told.
    """

    def __init__(self, options: Mapping[str, Any], config: PolicyConfig, seed: int) -> None:
        # With one thread the same seed gives the same bytes whatever the number of cores.
        torch.set_num_threads(1)
        torch.manual_seed(seed)
        self.config, columns = config, Columns(options)
        more = SUMMARY if config.ppo.critic == "central" else 0
        self.policy = Scorer(columns, config.hidden, each=2, common=2)
        self.critic = Scorer(columns, config.hidden, each=0, common=1, more=more)
        self.symmetries = symmetries(columns)
        self._optimizers = [torch.optim.Adam(net.parameters(), lr=1e-3, eps=1e-5) for net in self._networks]

    @property
    def _networks(self) -> tuple[Scorer, Scorer]:
        return self.policy, self.critic

    def batch(self, paths: Sequence[Path]) -> Batch:
        """The decisions of several agents and episodes, with what the critic has to say of them."""
        told, mask, more = (
            torch.from_numpy(np.stack([each[i] for path in paths for each in path.told])) for i in range(3)
        )
        values = self._values(told, more)
        found, first = list[float](), 0
        for path in paths:
            found += advantages(path, values[first : first + len(path.action)], self.config.ppo.trace_decay)
            first += len(path.action)
        advantage = torch.tensor(found)
        return Batch(
            told, more, mask.bool(), torch.tensor([action for path in paths for action in path.action]),
            torch.tensor([chance for path in paths for chance in path.chance]),
            (advantage - advantage.mean()) / (advantage.std() + 1e-8), advantage + torch.tensor(values),
        )  # fmt: skip

    def _values(self, told: torch.Tensor, more: torch.Tensor) -> list[float]:
        """What the critic expects."""
        with torch.no_grad():
            found: list[float] = self.critic(torch.cat([told, more], dim=1))[:, 0].tolist()
        return found

    def logits(self, told: torch.Tensor, mask: torch.Tensor) -> torch.Tensor:
        """Logarithms of the chances of all actions, shape (n, actions)."""
        return torch.log_softmax(self.policy(told).masked_fill(~mask, FORBIDDEN), dim=1)

    def decide(self, games: Sequence[Game], rng: np.random.Generator) -> Decided:
        """Decides for the agents that are asked.

        Args:
            games: Games in which somebody is asked.
            rng: Draws the actions.
        """
        each = [game.told() for game in games]
        told, mask = (torch.from_numpy(np.stack([one[i] for one in each])) for i in range(2))
        with torch.no_grad():
            logits = self.logits(told, mask.bool()).numpy()
        # The largest of logits with Gumbel noise is a draw by their softmax.
        actions = (logits + rng.gumbel(size=logits.shape)).argmax(axis=1).tolist()
        return Decided(actions, actions, logits[np.arange(len(games)), actions].tolist())

    def imitate(self, lessons: Lessons, left: float, rng: np.random.Generator) -> float:
        """A pass over decisions of the rule; returns the mean loss (cross entropy).

        Args:
            lessons: The decisions.
            left: Share of the imitation that is still to come, for the learning rate.
            rng: Draws the order, and the turns and mirrors.
        """
        config, losses = self.config.imitation, []
        self._rate(self._optimizers[0], config.learning_rate * left)
        for rows in _batches(len(lessons), config.batch, rng):
            told = torch.from_numpy(lessons.told[rows])
            if self.config.mirrored:
                order, signs = self.symmetries[int(rng.integers(len(self.symmetries)))]
                told = told[:, order] * torch.from_numpy(signs)
            logits = self.logits(told, torch.from_numpy(lessons.mask[rows]))
            loss = nn.functional.nll_loss(logits, torch.from_numpy(lessons.action[rows]))
            self._step(0, loss)
            losses.append(float(loss.detach()))
        return float(np.mean(losses))

    def agreement(self, lessons: Lessons) -> float:
        """Share of the rule's decisions that are the network's most likely ones."""
        with torch.no_grad():
            logits = self.logits(torch.from_numpy(lessons.told), torch.from_numpy(lessons.mask))
        return float((logits.argmax(dim=1).numpy() == lessons.action).mean())

    def learn(self, batch: Batch, left: float, critic_only: bool, rng: np.random.Generator) -> dict[str, float]:
        """Some passes over the decisions of an iteration.

        Args:
            batch: The decisions.
            left: Share of the training that is still to come, for the learning rate and the entropy's weight.
            critic_only: Whether the policy stays as it is.
            rng: Draws the order.

        Returns:
            Means of `entropy`, `critic` (its squared error) and `moved` (how far chances have moved, by the
            Kullback-Leibler divergence).
        """
        ppo, told = self.config.ppo, list[tuple[float, float, float]]()
        for optimizer in self._optimizers:
            self._rate(optimizer, ppo.learning_rate * left)
        for _ in range(ppo.epochs):
            for rows in map(torch.from_numpy, _batches(len(batch.action), ppo.batch, rng)):
                numbers, action = batch.told[rows], batch.action[rows]
                values = self.critic(torch.cat([numbers, batch.more[rows]], dim=1))[:, 0]
                error = nn.functional.mse_loss(values, batch.returned[rows])
                self._step(1, error)
                if critic_only:
                    told.append((0.0, float(error.detach()), 0.0))
                    continue
                logits = self.logits(numbers, batch.mask[rows])
                chance = logits.gather(1, action[:, None])[:, 0]
                ratio, advantage = torch.exp(chance - batch.chance[rows]), batch.advantage[rows]
                clipped = ratio.clamp(1.0 - ppo.clip, 1.0 + ppo.clip)
                gain = torch.minimum(ratio * advantage, clipped * advantage).mean()
                entropy = -(logits.exp() * logits).sum(dim=1).mean()
                self._step(0, -gain - ppo.entropy * left * entropy)
                moved = (ratio.detach() - 1.0 - (chance.detach() - batch.chance[rows])).mean()
                told.append((float(entropy.detach()), float(error.detach()), float(moved)))
        return dict(zip(("entropy", "critic", "moved"), np.mean(told, axis=0).tolist(), strict=True))

    def _rate(self, optimizer: torch.optim.Optimizer, rate: float) -> None:
        for group in optimizer.param_groups:
            group["lr"] = rate

    def _step(self, which: int, loss: torch.Tensor) -> None:
        optimizer = self._optimizers[which]
        optimizer.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        nn.utils.clip_grad_norm_(self._networks[which].parameters(), self.config.ppo.gradient_clip)
        optimizer.step()

    def forget(self) -> None:
        """Begins the optimizers anew: what imitation knew of gradients says nothing of those that follow."""
        self._optimizers = [torch.optim.Adam(net.parameters(), lr=1e-3, eps=1e-5) for net in self._networks]

    def dump(self) -> dict[str, NDArray[Any]]:
        """What a checkpoint needs: the networks and Adam's moments."""
        made: dict[str, NDArray[Any]] = {}
        for n, (network, optimizer) in enumerate(zip(self._networks, self._optimizers, strict=True)):
            for i, weights in enumerate(network.parameters()):
                made[f"weights_{n}_{i}"] = weights.detach().numpy().copy()
                moments = optimizer.state.get(weights)
                if moments:
                    made[f"mean_{n}_{i}"], made[f"square_{n}_{i}"] = (
                        moments["exp_avg"].numpy().copy(), moments["exp_avg_sq"].numpy().copy(),
                    )  # fmt: skip
                    made[f"steps_{n}_{i}"] = np.array(float(moments["step"]))
        return made

    def restore(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Takes back what `dump` gave, or the weights among it.

        Raises:
            KeyError: One of the arrays is missing.
            RuntimeError: One does not fit.
        """
        with torch.no_grad():
            for n, (network, optimizer) in enumerate(zip(self._networks, self._optimizers, strict=True)):
                for i, weights in enumerate(network.parameters()):
                    weights.copy_(torch.from_numpy(arrays[f"weights_{n}_{i}"]))
                    if f"mean_{n}_{i}" in arrays:
                        optimizer.state[weights] = {
                            "step": torch.tensor(float(arrays[f"steps_{n}_{i}"])),
                            "exp_avg": torch.from_numpy(arrays[f"mean_{n}_{i}"].copy()),
                            "exp_avg_sq": torch.from_numpy(arrays[f"square_{n}_{i}"].copy()),
                        }


def _batches(count: int, size: int, rng: np.random.Generator) -> list[NDArray[np.int64]]:
    """The numbers from 0 in a drawn order, in parts of about one size."""
    return np.array_split(rng.permutation(count), max(1, round(count / size)))
