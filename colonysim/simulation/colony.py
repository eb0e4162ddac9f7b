"""A colony that can be held: stepped, looked at, and gone on with."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from colonysim.arguments import as_seed, whole
from colonysim.errors import ColonysimError, PluginError
from colonysim.geometry.robot_choice import with_robot
from colonysim.plugins import make_backend, make_policy
from colonysim.policies.view import LocalView
from colonysim.randomness import Streams
from colonysim.scenario.loading import load_scenario
from colonysim.simulation.episode import Episode
from colonysim.simulation.foreign import checked_backend, checked_fields, checked_policy
from colonysim.simulation.foreign.answers import SHOWN
from colonysim.simulation.initial import load_fields
from colonysim.simulation.modes import mode_of
from colonysim.simulation.views import AgentsView, BoxesView, FieldsView, WorldView
from colonysim.suggest import nearest
from colonysim.trace.rows import Rows
from colonysim.trace.schema import EVENT_KINDS, Measurement
from colonysim.trace.writer import TraceWriter
from colonysim.world.state import World

if TYPE_CHECKING:
    from typing import Self

    from colonysim.backends.protocol import Backend
    from colonysim.policies.policy import Policy
    from colonysim.scenario.scenario import Scenario
    from colonysim.trace.schema import Event, Frame, Sink

__all__ = ["Colony"]

OBSERVED = (*EVENT_KINDS, "arrive", "fail")
"""What `Colony.on` can be asked for: kinds of events, and ends that arrived or did not."""


class Colony:
    """A colony under way: the same simulation as `simulate` and `run`, one event at a time.

    Pheromones and the agents' own memories persist over the episodes, everything else starts anew.

    Args:
        scenario: The colony: a scenario, the path of its file, or the name of one that comes with the package.
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
        kinds: Kinds of the events to hand out; None for all. A large world runs faster if nobody asks for "end".

    Raises:
        ColonysimError: Something that the caller asked for does not exist or does not fit.

    Example:
        ```python
        with colonysim.Colony("hard", seed=1) as colony:
            colony.run_until(time=60)
            print(colony.now, colony.agents.position, colony.fields["D"].values())
            colony.run_until(episode=3)
        ```
    """

    def __init__(
        self,
        scenario: Scenario | str | Path,
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
    ) -> None:
        scenario = with_robot(load_scenario(scenario) if isinstance(scenario, (str, Path)) else scenario)
        self.scenario, self.mode = scenario, mode_of(scenario, mode)
        self._count = scenario.episodes if episodes is None else whole("episodes", episodes)
        self._streams = Streams(as_seed(seed))
        self._kinds = _kinds(kinds)
        self._world, self._rows = World(scenario), Rows(scenario, sink, decisions, self._kinds)
        world, rows = self._world, self._rows
        self._policy = checked_policy(make_policy(policy, scenario), world, rows)
        self._fields = checked_fields(self._policy, world, rows)
        if isinstance(sink, TraceWriter):
            sink.describe({name: bool(field.by_box) for name, field in self._fields.items()})
        if initial:
            load_fields(world, self._fields, initial)
        made = make_backend(backend, backend_options, scenario)
        self._body = checked_backend(made, world, rows, recording=sink is not None)
        agents = range(len(scenario.agents))
        self._memories: list[Any] = [None for _ in agents]
        self._number, self._running, self._aged, self._closed = 0, False, True, False
        self._reached, self._sample = 0.0, inf
        self._observers: list[tuple[str, Callable[[Event, Colony], object]]] = []
        self._measures: list[_Measure] = []
        self._measured: list[Measurement] = []
        try:
            views = [LocalView(world, self._fields, self._body, agent) for agent in agents]
            self._episode = Episode(world, self._fields, self._body, self._policy, views, rows)
        except BaseException:
            with suppress(Exception):  # what went wrong first is what counts
                self._body.close()
            raise
        self._agents, self._boxes = AgentsView(world, self._episode, views), BoxesView(world)
        self._shown_fields, self._place = FieldsView(world, self._fields), WorldView(world)

    # -- going on ----------------------------------------------------------------------------------------------------

    def step(self) -> Event | None:
        """Goes on to the next event.

        Several events can happen at one moment: an action ends, say, and its agent is at the goal. They are handed
        out one by one, and the colony shows the state after all of them.

        Returns:
            The event; None if all episodes are over.
        """
        return self._next(inf)

    def run_until(
        self,
        *,
        time: float | None = None,
        event: str | Callable[[Event], bool] | None = None,
        episode: int | None = None,
    ) -> Event | None:
        """Goes on until something is so.

        Args:
            time: Until this simulated second of the episode under way (of the first one, if none is), or its end if
                that is sooner. Everything that is due by then has happened.
            event: Until the first event of a kind (see `on`), or for which a function is true.
            episode: Until the episode of this number has ended.

        Returns:
            The last event on the way; None if there was none.

        Raises:
            ColonysimError: Not exactly one of them is given, or what is given cannot be.
        """
        given = [name for name, value in (("time", time), ("event", event), ("episode", episode)) if value is not None]
        if len(given) != 1:
            raise ColonysimError(f"run_until takes one of time, event and episode, not {' and '.join(given) or 'none'}")
        if time is not None:
            return self._run_until_time(time)
        if episode is not None:
            number = whole("episode", episode, 1)
            if number > self._count:
                raise ColonysimError(f"episode: {number}, but there are {self._count}")
            met: Callable[[Event], bool] = lambda event: event.kind == "episode" and event.episode >= number  # noqa: E731
            if self._number > number or (self._number == number and not self._running):
                return None
        elif callable(event):
            met = event
        else:
            kind = self._observable(event)
            met = lambda event: _is(kind, event)  # noqa: E731
        last = None
        while (came := self._next(inf)) is not None:
            last = came
            if met(came):
                break
        return last

    def _run_until_time(self, time: float) -> Event | None:
        if isinstance(time, bool) or not isinstance(time, (int, float)) or not isfinite(time) or time < 0:
            raise ColonysimError(f"time is {time!r}, expected a number of simulated seconds from 0")
        last = None
        while (came := self._next(time)) is not None:
            last = came
            if came.kind == "episode":
                return last
        if self._running:
            self._reached = max(self._reached, float(time))
        return last

    def __iter__(self) -> Iterator[Event]:
        """All events that are still to come."""
        events = self._rows.events
        while events or self._fill(inf):
            while events and not self._observers:
                yield events.pop(0)
            if events:
                yield self._told(events.pop(0))

    def _next(self, until: float) -> Event | None:
        """The next event that is due by a time of the episode under way; None if there is none."""
        events = self._rows.events
        return self._told(events.pop(0)) if events or self._fill(until) else None

    def _told(self, event: Event) -> Event:
        for kind, call in self._observers:
            if _is(kind, event):
                call(event, self)
        return event

    def _fill(self, until: float) -> bool:
        """Lets the colony go on until events have come out; False if none have by a time of the episode under way."""
        if self._closed:
            return False
        events, episode = self._rows.events, self._episode
        try:
            while self._running or self._begin_next():
                if events or episode.go_on(until if until < self._sample else self._sample):
                    return True
                if episode.over:
                    self._finish()
                    if events:
                        return True
                elif self._sample <= until:
                    self._measure(self._sample)
                else:
                    return False
            self.close()
        except BaseException:
            self._fail()
            raise
        return False

    def _finish(self) -> None:
        """Ends the episode that is over; what is measured at its end comes before its last event is handed out."""
        self._episode.finish()
        self._running = False
        self._measure(inf)

    def _begin_next(self) -> bool:
        """Begins the next episode; False if there is none."""
        if not self._aged:  # now, and not with the last event: until then the fields are as the agents left them
            for field in self._fields.values():
                field.end_episode()
            self._aged = True
        if self._number == self._count:
            return False
        self._number += 1
        own = self._streams.within(f"episode/{self._number}")
        self._world.reset()
        self._body.reset(self._world, own)
        self._memories = [self._policy.begin(agent, memory) for agent, memory in enumerate(self._memories)]
        self._running, self._aged, self._reached = True, False, 0.0
        for measure in self._measures:
            measure.due = measure.every
        self._set_sample()
        self._episode.begin(self._number, self._memories, own, synchronous=self.mode == "synchronous")
        return True

    # -- looking on --------------------------------------------------------------------------------------------------

    @property
    def now(self) -> float:
        """Simulated seconds since the start of the episode under way, or how long the last one took."""
        return max(self._reached, self._episode.now) if self._number else 0.0

    @property
    def episode(self) -> int:
        """Number of the episode under way, or of the last one; 0 before the first."""
        return self._number

    @property
    def over(self) -> bool:
        """Whether all episodes have ended and every event has been handed out."""
        return not self._rows.events and (self._closed or (self._number == self._count and not self._running))

    @property
    def agents(self) -> AgentsView:
        """The agents."""
        return self._agents

    @property
    def boxes(self) -> BoxesView:
        """The boxes."""
        return self._boxes

    @property
    def fields(self) -> FieldsView:
        """The pheromone fields by name."""
        return self._shown_fields

    @property
    def world(self) -> WorldView:
        """The place."""
        return self._place

    def on(self, kind: str, call: Callable[[Event, Colony], object]) -> Callable[[], None]:
        """Has a function called with each event of a kind, and the colony, right before it is handed out.

        Args:
            kind: A kind of `Event`, or "arrive" or "fail": an action ended as intended, or did not.
            call: The function. It may look at the colony; what it raises ends the colony.

        Returns:
            A function that ends this.

        Raises:
            ColonysimError: There is no such kind, or this colony does not hand it out (`kinds`).
        """
        observer = (self._observable(kind), call)
        self._observers = [*self._observers, observer]

        def end() -> None:
            self._observers = [other for other in self._observers if other is not observer]

        return end

    def _observable(self, kind: object) -> str:
        if kind not in OBSERVED:
            raise ColonysimError(f"no events of kind {kind!r}; {nearest(str(kind), OBSERVED)}")
        if self._kinds is not None and _event_kind(str(kind)) not in self._kinds:
            raise ColonysimError(f"no events of kind {kind!r} here: kinds, as it was given, leaves them out")
        return str(kind)

    def measure(self, name: str, call: Callable[[Colony], float], *, every: float | None = None) -> None:
        """Measures something of one's own: at the end of each episode, or every so many simulated seconds too.

        The values are `measurements`, and rows of that table of the trace.

        Args:
            name: What it is called in the table.
            call: Takes the colony, returns a number. What it raises ends the colony.
            every: Simulated seconds from one value to the next, None for the end of each episode only.

        Raises:
            ColonysimError: There is one of that name already, or `every` is no time.
        """
        if not isinstance(name, str) or not name or any(measure.name == name for measure in self._measures):
            raise ColonysimError(f"measure: the name {name!r} is taken or is no text; expected a new one")
        if every is not None and not (isinstance(every, (int, float)) and isfinite(every) and every > 0):
            raise ColonysimError(f"measure: every is {every!r}, expected simulated seconds above 0")
        period = inf if every is None else float(every)
        due = inf if every is None else period * (self.now // period + 1)
        self._measures.append(_Measure(name, call, period, due if self._running else period))
        self._set_sample()

    @property
    def measurements(self) -> tuple[Measurement, ...]:
        """What has been measured so far, in order."""
        return tuple(self._measured)

    def _set_sample(self) -> None:
        """When the next value is to be measured, simulated seconds of the episode; never: infinity."""
        self._sample = min((measure.due for measure in self._measures), default=inf)

    def _measure(self, time: float) -> None:
        """Takes the values that are due at a time; at the end of an episode (infinity) all of them."""
        self._reached = max(self._reached, time) if time < inf else self._reached
        for measure in self._measures:
            if time < measure.due:
                continue
            value = _number(measure.name, measure.call(self))
            self._measured.append(Measurement(self._number, self.now, measure.name, value))
            self._rows.measured(self._measured[-1])
            measure.due += measure.every
        self._set_sample()

    # -- the end -----------------------------------------------------------------------------------------------------

    def close(self) -> None:
        """Lets go of the backend; a colony that is closed can be looked at, but does not go on. May be called again."""
        if self._closed:
            return
        self._closed = True
        try:
            self._body.close()
        finally:
            self._episode.close()

    def _fail(self) -> None:
        with suppress(Exception):  # what went wrong first is what counts
            self.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        if kind is None:
            self.close()
        else:
            self._fail()

    def __repr__(self) -> str:
        where = f"episode {self._number} of {self._count}, {self.now:.1f} s" if self._number else "not begun"
        there = int((self._agents.status == "goal").sum())
        return f"<Colony {self.scenario.name}: {where}, {there} of {len(self._agents)} agents at the goal>"

    def _repr_html_(self) -> str:
        """A notebook's picture: the map with what is where now."""
        from colonysim.simulation.picture import picture

        return picture(self)


class _Measure:
    """A measurement of the user's own and when it is due next, simulated seconds of the episode."""

    __slots__ = ("call", "due", "every", "name")

    def __init__(self, name: str, call: Callable[[Colony], float], every: float, due: float) -> None:
        self.name, self.call, self.every, self.due = name, call, every, due


def _number(name: str, value: object) -> float:
    """The value of a measurement as a number.

    Raises:
        PluginError: It is none.
    """
    try:
        if isinstance(value, (bool, str, bytes)):
            raise TypeError
        return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise PluginError(f"measurement {name!r} is {SHOWN.repr(value)}, expected a number") from None


def _kinds(kinds: Collection[str] | None) -> Collection[str] | None:
    if isinstance(kinds, str):
        raise ColonysimError(f"kinds is {kinds!r}, expected a list of kinds, such as [{kinds!r}]")
    for kind in () if kinds is None else kinds:
        if kind not in EVENT_KINDS:
            raise ColonysimError(f"kinds: no events of kind {kind!r}; {nearest(str(kind), EVENT_KINDS)}")
    return kinds


def _event_kind(kind: str) -> str:
    return "end" if kind in ("arrive", "fail") else kind


def _is(kind: str, event: Event) -> bool:
    """Whether an event is what `Colony.on` was asked for."""
    if kind in ("arrive", "fail"):
        return event.kind == "end" and (event.status == "arrived") == (kind == "arrive")
    return event.kind == kind
