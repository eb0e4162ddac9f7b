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

    The arguments are those of `Colony`, and so is what it raises, once the first event is asked for.

    Yields:
        Events in the order of simulated time. An "episode" event closes each episode.
    """
    with Colony(
        scenario, backend=backend, policy=policy, mode=mode, episodes=episodes, seed=seed, sink=sink, initial=initial,
        decisions=decisions, backend_options=backend_options, kinds=kinds,
    ) as colony:  # fmt: skip
        yield from colony
