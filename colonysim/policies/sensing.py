"""Sensors that err: boxes that are not seen, nodes that seem to lie elsewhere, marks that are misread.

An error belongs to a look, that is, to one decision of one agent: whoever asks twice before it has decided gets the
same answer, and whoever looks through its eyes meanwhile changes nothing.
Each is computed from a number drawn for the look and from what is looked at, so that it depends neither on the order
of the questions nor on how many there are.
"""

from __future__ import annotations

import zlib
from array import array
from math import sqrt
from typing import TYPE_CHECKING

from colonysim.draws import Keyed
from colonysim.exact import log

if TYPE_CHECKING:
    from colonysim.draws import Draws
    from colonysim.scenario.faults import Faults
    from colonysim.world.topology import Topology

__all__ = ["Senses", "tag_of"]

BITS = 9007199254740992.0
"""2 to the power of 53: so many numbers can be drawn for a look."""
OF_BOXES, OF_NODES, OF_MARKS = 0x243F6A8885A308D3, 0x13198A2E03707344, 0xA4093822299F31D0
"""Tell errors of one kind in a look from those of another: digits of pi."""


class Senses:
    """What the sensors of a colony's agents make of what is there.

    Args:
        faults: How much they err.
        topology: The place.

    Attributes:
        misses: Whether boxes may be missed.
        misplaces: Whether nodes may seem to lie elsewhere.
        misreads: Whether marks may be misread.
        x: For the nodes that were looked at last, where they seem to lie: east coordinate, graph units.
        y: The north coordinate.
        lengths: For each edge between those, how long it seems, graph units.
    """

    def __init__(self, faults: Faults, topology: Topology) -> None:
        self._missed, self._spread, self._noise = faults.box_missed, faults.node_misplaced, faults.mark_noise
        self.misses, self.misplaces, self.misreads = self._missed > 0.0, self._spread > 0.0, self._noise > 0.0
        size = len(topology) if self.misplaces else 0
        self.true_x, self.true_y = (array("d", topology.x), array("d", topology.y)) if size else (array("d"),) * 2
        self.x, self.y = array("d", bytes(8 * size)), array("d", bytes(8 * size))
        self.lengths = array("d", topology.edges.lengths) if size else array("d")
        self._errors, self._second = Keyed(), 0.0
        self.looks: Draws | None = None

    def look(self, agent: int) -> int:
        """The number of an agent's look, the same until it has decided."""
        assert self.looks is not None
        return int(self.looks.ahead(agent) * BITS)

    def decided(self, agent: int) -> None:
        """An agent has decided by what it saw: its next look errs anew."""
        assert self.looks is not None
        self.looks.draw(agent)

    def overlooks(self, look: int, box: int) -> bool:
        """Whether a box is not seen in a look."""
        self._errors.begin(look ^ OF_BOXES, box, 0)
        return self._errors.draw() < self._missed

    def place(self, look: int, node: int, exact: bool) -> None:
        """Writes where a node seems to lie in a look into `x` and `y`; the true place if `exact`."""
        east, north = self.true_x[node], self.true_y[node]
        if not exact:
            self._errors.begin(look ^ OF_NODES, node, 0)
            east += self._spread * self._normal()
            north += self._spread * self._second
        self.x[node], self.y[node] = east, north

    def factor(self, look: int, field: int, node: int, key: int) -> float:
        """What the value of a field at a node is multiplied by as it is read in a look; never below 0."""
        self._errors.begin((look ^ OF_MARKS) + field, node, key)
        factor = 1.0 + self._noise * self._normal()
        return factor if factor > 0.0 else 0.0

    def _normal(self) -> float:
        """A standard normal number; another one stands in `_second`: Marsaglia's polar method."""
        square, errors = 0.0, self._errors
        while not 0.0 < square < 1.0:
            one, other = 2.0 * errors.draw() - 1.0, 2.0 * errors.draw() - 1.0
            square = one * one + other * other
        wide = sqrt(-2.0 * log(square) / square)
        self._second = wide * other
        return wide * one


def tag_of(name: str) -> int:
    """A number for a field's name: the same in every run."""
    return zlib.crc32(name.encode("utf-8", "replace"))
