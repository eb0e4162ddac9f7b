"""A push seen in a mirror: what is true of a push to the left is true of one to the right.

Nothing in the robot, the box or the terrains prefers a side, so that every transition that was lived through tells of a
second one, reflected in the push line.
"""

import numpy as np
import numpy.typing as npt

from colonysim.push.controls import CONTROLS, Control
from colonysim.push.network import Inputs
from colonysim.push.training.replay import Batch

__all__ = ["mirror_signs", "mirrored", "mirrored_control"]

_SIGNS: dict[Inputs, tuple[int, ...]] = {
    "state": (1, -1, 1, 1, -1, 1, -1, 1, -1),
    "line": (1, -1, 1, 1, -1, 1, 1, -1, 1, 1, -1, 1, -1, 1, 1, 1, -1, 1, -1, -1, -1, 1, 1),
}
_OTHER = np.arange(CONTROLS)
_OTHER[[Control.PUSH_LEFT, Control.PUSH_RIGHT]] = Control.PUSH_RIGHT, Control.PUSH_LEFT


def mirror_signs(inputs: Inputs) -> npt.NDArray[np.float32]:
    """Factors that turn an encoded state into that of its mirror image, shape (width of the inputs,)."""
    return np.array(_SIGNS[inputs], dtype=np.float32)


def mirrored_control(control: int) -> Control:
    """The control that does in the mirror what `control` does."""
    return Control(int(_OTHER[control]))


def mirrored(batch: Batch, signs: npt.NDArray[np.float32], rng: np.random.Generator) -> Batch:
    """A batch with each transition replaced by its mirror image with a chance of one half.

    Args:
        batch: Transitions with encoded states.
        signs: `mirror_signs` of the encoding.
        rng: Source of randomness, advanced.
    """
    turned = rng.random(len(batch.actions)) < 0.5
    factors = np.where(turned[:, None], signs, np.float32(1.0))
    return batch._replace(
        states=batch.states * factors,
        actions=np.where(turned, _OTHER[batch.actions], batch.actions),
        next_states=batch.next_states * factors,
    )
