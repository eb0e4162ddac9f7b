"""What goes wrong in a colony, by random streams of its own: moves, marks, stops; sensors in `policies/sensing`."""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING

from colonysim.exact import log
from colonysim.policies.sensing import Senses

if TYPE_CHECKING:
    from collections.abc import Iterable

    from colonysim.draws import Draws
    from colonysim.randomness import Streams
    from colonysim.scenario.faults import Faults
    from colonysim.states import State, Stored
    from colonysim.world.topology import Topology

__all__ = ["FAILED", "Breakdowns"]

FAILED = "fault"
"""The reason of a move that fails by chance."""


class Breakdowns:
    """Draws what goes wrong: for each agent and each kind a stream of its own, of which nothing else draws.

    Args:
        faults: How often what goes wrong.
        topology: The place.
        agents: How many agents there are.
        fields: Names of the fields in which they leave marks.

    Attributes:
        senses: What the agents' sensors make of what is there; None if they do not err.
        moves: Whether moves may fail.
        loses: Whether marks may be lost.
        stops: Whether agents may stop.
    """

    def __init__(self, faults: Faults, topology: Topology, agents: int, fields: Iterable[str]) -> None:
        self._faults, self._agents, self._fields = faults, agents, tuple(fields)
        self.senses = Senses(faults, topology) if faults.of_sensors else None
        self.moves, self.loses, self.stops = faults.move_fails > 0, faults.mark_lost > 0, faults.stop_every > 0
        self._next_stop = array("d", [0.0]) * agents
        self._streams: dict[str, Draws] = {}

    def begin(self, streams: Streams) -> None:
        """An episode begins.

        Args:
            streams: The episode's random streams.
        """
        self._take(self._named(streams))
        for agent in range(self._agents if self.stops else 0):
            self._next_stop[agent] = self._until_next(agent)

    def reseed(self, streams: Streams) -> None:
        """Draws from now on from other streams of the episode; stops that are due already stay so."""
        self._take(self._named(streams))

    def _named(self, streams: Streams) -> dict[str, Draws]:
        own = streams.within(f"faults/{self._faults.seed}")
        names = ["moves", "looks", "stops", *(f"marks/{name}" for name in self._fields)]
        return {name: own.draws(name, self._agents) for name in names}

    def _take(self, streams: dict[str, Draws]) -> None:
        self._streams = streams
        self._marks = [streams[f"marks/{name}"] for name in self._fields]
        if self.senses is not None:
            self.senses.looks = streams["looks"]

    def fails(self, agent: int) -> bool:
        """Whether the move that an agent begins will fail."""
        return self._streams["moves"].draw(agent) < self._faults.move_fails

    def mark_lost(self, agent: int, field: int) -> bool:
        """Whether the marks of a field, by its place among all, are lost that an agent is to leave now."""
        return self._marks[field].draw(agent) < self._faults.mark_lost

    def still_until(self, agent: int, now: float, rested: bool) -> float:
        """Until when an agent that is about to choose stands still; 0 if it does not.

        A stop begins when it is due, or when the move under way then has ended. Who waits when it is due need not be
        woken for it: whether it still stands still is asked when it next chooses.

        Args:
            agent: The agent.
            now: Simulated seconds of the episode.
            rested: Whether it has been waiting up to now, and not moving.
        """
        until = 0.0
        while self._next_stop[agent] <= now:
            begins = self._next_stop[agent] if rested else now
            until = begins + self._faults.stop_seconds
            self._next_stop[agent] = until + self._until_next(agent)
        return until

    def _until_next(self, agent: int) -> float:
        """Seconds from now, or from the end of a stop, to the next stop."""
        return -self._faults.stop_every * log(1.0 - self._streams["stops"].draw(agent))

    # -- plain data --------------------------------------------------------------------------------------------------

    def state(self) -> State:
        """Where an episode's streams have come to, and when each agent's next stop is due."""
        streams = {name: draws.numbers() for name, draws in self._streams.items()}
        return {"streams": streams, "next_stop": array("d", self._next_stop)}

    def restore(self, told: Stored) -> None:
        """Takes over a state, after `begin`.

        Raises:
            ColonysimError: It is none.
        """
        streams = told.part("streams")
        for name, draws in self._streams.items():
            draws.resume(streams.column(name, "Q", self._agents, 0, 2**64 - 1))
        self._next_stop = array("d", told.column("next_stop", "d", self._agents, 0.0))
