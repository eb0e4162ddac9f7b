"""The colony as a place to learn in: environments of colonies and of the push, and files of learned policies.

The environments need the extra `rl`; a learned policy runs without. Importing this registers the push environments
(`colonysim/Push-v0` and so on), where Gymnasium is installed.

Example:
    ```python
    from colonysim import rl

    env = rl.aec("hard", seed=1)
    env.reset()
    for agent in env.agent_iter():
        observation, reward, terminated, truncated, info = env.last()
        action = None if terminated or truncated else env.action_space(agent).sample(info["action_mask"])
        env.step(action)
    ```
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from colonysim.errors import MissingExtraError
from colonysim.installing import install_command
from colonysim.rl.models import PolicyModel, load_policy, save_policy, shipped_policies
from colonysim.rl.options import Options
from colonysim.rl.rewards import REWARDS, Reward, Stretch

_missing = ""
try:
    from colonysim.push.registered import register
    from colonysim.rl.aec import ColonyAEC
    from colonysim.rl.parallel import ColonyParallel
    from colonysim.rl.rllib import ColonyMultiAgent
    from colonysim.rl.turns import Turns

    register()
except ModuleNotFoundError as error:
    if error.name not in ("gymnasium", "pettingzoo"):
        raise
    _missing = error.name

if TYPE_CHECKING:
    from pathlib import Path
    from typing import Unpack

    from colonysim.scenario.scenario import Scenario

__all__ = [
    "REWARDS", "ColonyAEC", "ColonyMultiAgent", "ColonyParallel", "Options", "PolicyModel", "Reward", "Stretch",
    "Turns", "aec", "load_policy", "multi_agent", "parallel", "save_policy", "shipped_policies",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name in __all__:
        _need_extra()
    raise AttributeError(f"module 'colonysim.rl' has no attribute {name!r}")


def _need_extra() -> None:
    """Environments need packages that a learned policy can be run without."""
    if _missing:
        raise MissingExtraError(f"learning needs {_missing}: {install_command('rl')}")


def aec(
    scenario: Scenario | str | Path, *, render_mode: str | None = None, **options: Unpack[Options]
) -> ColonyAEC:
    """A colony as PettingZoo's `AECEnv`: one call for each decision, in simulated time.

    Args:
        scenario: The place: a scenario, the path of its file, or the name of one that comes with the package.
        render_mode: "rgb_array" for `render` to give images, "human" for a window that follows (extra `window`).
        **options: See `Options`.

    Raises:
        ColonysimError: Something that is asked for does not exist or does not fit.
        MissingExtraError: Something is not installed that this needs.
    """
    _need_extra()
    return ColonyAEC(Turns(scenario, **options), render_mode)


def parallel(
    scenario: Scenario | str | Path, *, render_mode: str | None = None, **options: Unpack[Options]
) -> ColonyParallel:
    """A colony as PettingZoo's `ParallelEnv`: a step leads to the next decision; the others are busy.

    Args:
        scenario: The place.
        render_mode: "rgb_array" for `render` to give images, "human" for a window that follows (extra `window`).
        **options: See `Options`.

    Raises:
        ColonysimError: Something that is asked for does not exist or does not fit.
        MissingExtraError: Something is not installed that this needs.
    """
    _need_extra()
    return ColonyParallel(Turns(scenario, busy=True, **options), render_mode)


def multi_agent(
    scenario: Scenario | str | Path, *, render_mode: str | None = None, **options: Unpack[Options]
) -> ColonyMultiAgent:
    """A colony by the conventions of RLlib's `MultiAgentEnv`: the dicts hold those who act next.

    Args:
        scenario: The place.
        render_mode: "rgb_array" for `render` to give images, "human" for a window that follows (extra `window`).
        **options: See `Options`.

    Raises:
        ColonysimError: Something that is asked for does not exist or does not fit.
        MissingExtraError: Something is not installed that this needs.

    Example:
        ```python
        class Environment(rl.ColonyMultiAgent, MultiAgentEnv):  # RLlib looks for its own class
            def __init__(self, config):
                MultiAgentEnv.__init__(self)
                rl.ColonyMultiAgent.__init__(self, rl.Turns("hard", **config))
        ```
    """
    _need_extra()
    return ColonyMultiAgent(Turns(scenario, **options), render_mode)
