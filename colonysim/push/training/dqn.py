"""Double DQN (paper Alg. 1, Eq. 10). Needs torch, and is imported by training only."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from torch import nn

from colonysim.learning.layers import Layer
from colonysim.push.network import QNetwork
from colonysim.push.training.presets import LearnerConfig, Target
from colonysim.push.training.replay import Batch

__all__ = ["DoubleDQN", "double_dqn_target"]


def double_dqn_target(
    form: Target,
    returns: torch.Tensor,
    discounts: torch.Tensor,
    online_next: torch.Tensor,
    target_next: torch.Tensor,
) -> torch.Tensor:
    """What Q of the taken controls should be.

    Args:
        form: See `LearnerConfig.target`.
        returns: Rewards gathered, shape (n,).
        discounts: Weight of what follows, 0 after an end, shape (n,).
        online_next: Online network's values of the next states, shape (n, controls).
        target_next: Target network's values of the next states, shape (n, controls).
    """
    chooser, judge = (online_next, target_next) if form == "standard" else (target_next, online_next)
    best = chooser.argmax(dim=1, keepdim=True)
    return returns + discounts * judge.gather(1, best).squeeze(1)


class DoubleDQN:
    """An online and a target network, and the optimizer that moves them.

    Args:
        start: The untrained network.
        config: Parameters.
    """

    def __init__(self, start: QNetwork, config: LearnerConfig) -> None:
        # Batches are too small to gain from threads, and sums that are split otherwise round otherwise: with one
        # thread the same seed gives the same bytes whatever the number of cores.
        torch.set_num_threads(1)
        self.config = config
        self.inputs = start.inputs
        self.updates = 0
        self._online = _module(start)
        self._target = _module(start)
        self._average = _module(start) if config.average_share is not None else self._online
        self._optimizer = torch.optim.Adam(self._online.parameters(), lr=config.learning_rate, fused=True)
        self._loss: nn.Module = nn.SmoothL1Loss() if config.loss == "huber" else nn.MSELoss()
        # The views share memory with the parameters, so that acting always uses the newest weights.
        self.network = QNetwork(start.inputs, tuple(_layers(self._online)))
        self.tested = QNetwork(start.inputs, tuple(_layers(self._average)))

    def update(self, batch: Batch, progress: float) -> float:
        """One gradient step; returns the loss.

        Args:
            batch: Transitions with encoded states.
            progress: Share of the training done, for the learning rate.
        """
        config = self.config
        rate = config.learning_rate + min(1.0, progress) * (config.learning_rate_end - config.learning_rate)
        for group in self._optimizer.param_groups:
            group["lr"] = rate
        states, next_states = torch.from_numpy(batch.states), torch.from_numpy(batch.next_states)
        with torch.no_grad():
            wanted = double_dqn_target(
                config.target,
                torch.from_numpy(batch.returns),
                torch.from_numpy(batch.discounts),
                self._online(next_states),
                self._target(next_states),
            )
        found = self._online(states).gather(1, torch.from_numpy(batch.actions)[:, None]).squeeze(1)
        loss = self._loss(found, wanted)
        self._optimizer.zero_grad()
        loss.backward()
        if config.gradient_clip is not None:
            nn.utils.clip_grad_norm_(self._online.parameters(), config.gradient_clip)
        self._optimizer.step()
        self.updates += 1
        self._move_target()
        if config.average_share is not None:
            _mix(self._average, self._online, config.average_share)
        return float(loss.detach())

    def dump(self) -> dict[str, npt.NDArray[Any]]:
        """What a checkpoint needs: the networks and Adam's moments."""
        made: dict[str, npt.NDArray[Any]] = {"updates": np.array(self.updates)}
        for i, (online, target, average) in enumerate(self._parameters()):
            made[f"online_{i}"], made[f"target_{i}"] = online.detach().numpy(), target.detach().numpy()
            made[f"average_{i}"] = average.detach().numpy()
            moments = self._optimizer.state.get(online)
            if moments:
                made[f"mean_{i}"], made[f"square_{i}"] = (
                    moments["exp_avg"].numpy(),
                    moments["exp_avg_sq"].numpy(),
                )
        return made

    def restore(self, arrays: Mapping[str, npt.NDArray[Any]]) -> None:
        """Take back what `dump` gave."""
        self.updates = int(arrays["updates"])
        with torch.no_grad():
            for i, (online, target, average) in enumerate(self._parameters()):
                average.copy_(torch.from_numpy(arrays[f"average_{i}"]))
                online.copy_(torch.from_numpy(arrays[f"online_{i}"]))
                target.copy_(torch.from_numpy(arrays[f"target_{i}"]))
                if f"mean_{i}" in arrays:
                    self._optimizer.state[online] = {
                        "step": torch.tensor(float(self.updates)),
                        "exp_avg": torch.from_numpy(arrays[f"mean_{i}"].copy()),
                        "exp_avg_sq": torch.from_numpy(arrays[f"square_{i}"].copy()),
                    }

    def _parameters(self) -> list[tuple[nn.Parameter, nn.Parameter, nn.Parameter]]:
        networks = self._online, self._target, self._average
        return list(zip(*(network.parameters() for network in networks), strict=True))

    def _move_target(self) -> None:
        every = self.config.target_every
        if every is not None and self.updates % every:
            return
        _mix(self._target, self._online, 1.0 if every is not None else self.config.target_share)


def _mix(into: nn.Module, network: nn.Module, share: float) -> None:
    with torch.no_grad():
        for mixed, own in zip(into.parameters(), network.parameters(), strict=True):
            mixed.lerp_(own, share)


def _module(network: QNetwork) -> nn.Sequential:
    parts: list[nn.Module] = []
    for weights, biases in network.layers:
        if parts:
            parts.append(nn.ReLU())
        linear = nn.Linear(weights.shape[1], weights.shape[0])
        with torch.no_grad():
            linear.weight.copy_(torch.from_numpy(weights.copy()))
            linear.bias.copy_(torch.from_numpy(biases.copy()))
        parts.append(linear)
    return nn.Sequential(*parts)


def _layers(module: nn.Sequential) -> list[Layer]:
    return [(m.weight.detach().numpy(), m.bias.detach().numpy()) for m in module if isinstance(m, nn.Linear)]
