"""The discrete-event simulation, the only place that knows SimPy: agents in their own time, episode after episode."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from colonysim.simulation.colony import Colony
from colonysim.simulation.modes import MODES, mode_of

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Iterator, Mapping

    from colonysim.backends.protocol import Backend
    from colonysim.policies.policy import Policy
    from colonysim.scenario.scenario import Scenario
    from colonysim.trace.schema import Event, Frame, Sink

__all__ = ["MODES", "Colony", "mode_of", "simulate"]


def simulate(
    scenario: Scenario,
    *,
    backend: str | Backend = "nodeworld",
    policy: str | Policy | Callable[[Scenario], Policy] | None = None,
    mode: str | None = None,
    episodes: int | None = None,
    seed: int = 0,
    sink: Sink | None = None,
    initial: Mapping[str, Iterable[Frame]] | None = None,
    decisions: bool = True,
    backend_options: Mapping[str, Any] | None = None,
    kinds: Collection[str] | None = None,
) -> Iterator[Event]:
    """Runs a colony and yields what happens, as it happens; to stop in between and look at it, take a `Colony`.

    Pheromones and the agents' own memories persist over the episodes, everything else starts anew.

    Args:
        scenario: The colony.
        backend: Name of a backend, or one.
        policy: Name of a policy, a factory, or a policy; the scenario's own if None.
        mode: "asynchronous" or "synchronous"; the scenario's own if None.
        episodes: How many; the scenario's own number if None.
        seed: Together with the scenario it makes the run; a whole number from 0.
        sink: Takes the rows of all tables of the trace.
        initial: Pheromones to start with, by field name: the key frames of another run's episode, as they would
            have been at the start of its next one.
        decisions: Whether the sink also gets the decisions.
        backend_options: Keyword arguments for a backend given by name.
        kinds: Kinds of the events to yield; None for all. A large world runs faster if nobody asks for "end".

    Yields:
        Events in the order of simulated time. An "episode" event closes each episode.

    Raises:
        ColonysimError: Something that the caller asked for does not exist or does not fit.
    """
    with Colony(
        scenario, backend=backend, policy=policy, mode=mode, episodes=episodes, seed=seed, sink=sink, initial=initial,
        decisions=decisions, backend_options=backend_options, kinds=kinds,
    ) as colony:  # fmt: skip
        yield from colony
