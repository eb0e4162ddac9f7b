"""A colony that can be held: stepped, looked at, and gone on with."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast
from weakref import finalize

from colonysim.arguments import as_seed, real, whole
from colonysim.backends.changes import refuse_changes
from colonysim.errors import ColonysimError
from colonysim.geometry.robot_choice import with_robot
from colonysim.plugins import make_backend
from colonysim.policies.policy import Choice
from colonysim.policies.view import LocalView
from colonysim.provenance import files_of
from colonysim.randomness import Streams
from colonysim.scenario.changes import refuse_unknown_marks
from colonysim.scenario.groups import refuse_speeds
from colonysim.scenario.loading import load_scenario
from colonysim.scenario.scenario import Scenario
from colonysim.simulation.adopting import adopt, diverge
from colonysim.simulation.by_hand import change_by_hand, kinds_by_hand
from colonysim.simulation.course import Course
from colonysim.simulation.episode import Episode
from colonysim.simulation.foreign import checked_backend
from colonysim.simulation.foreign.answers import SHOWN
from colonysim.simulation.groups import GroupPolicies
from colonysim.simulation.initial import load_fields
from colonysim.simulation.keeping import closed_on_error, loaded, refuse_other_files, restore, saved_of
from colonysim.simulation.measuring import Measures
from colonysim.simulation.modes import mode_of
from colonysim.simulation.origins import origin_of
from colonysim.simulation.saving import read_saved, write_saved
from colonysim.simulation.tuning import check_tunings, merged, tuned
from colonysim.simulation.views import AgentsView, BoxesView, FieldsView, WorldView
from colonysim.suggest import nearest
from colonysim.trace.checks import LONGEST
from colonysim.trace.rows import Rows
from colonysim.trace.schema import EVENT_KINDS
from colonysim.trace.writer import TraceWriter
from colonysim.world.state import AgentStatus, World

if TYPE_CHECKING:
    from typing import Self

    from colonysim.backends.protocol import Backend
    from colonysim.policies.policy import Policy
    from colonysim.scenario.changes import Change
    from colonysim.simulation.foreign import ForeignPolicy
    from colonysim.simulation.origins import Origin
    from colonysim.simulation.tuning import Tuning
    from colonysim.trace.schema import Event, Frame, Measurement, Sink
    from colonysim.world.intents import Intent

__all__ = ["Colony"]

OBSERVED = (*EVENT_KINDS, "arrive", "fail")
"""What `Colony.on` can be asked for: kinds of events, and ends that arrived or did not."""


_MOVING: set[int] = set()
"""Backends, by their `id`, that move a colony that is not closed."""


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
        origin: How backend and policy were asked for, where the objects themselves are given, for `save`.

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
        origin: Origin | None = None,
    ) -> None:
        if isinstance(scenario, (str, Path)):
            scenario = load_scenario(scenario)
        if not isinstance(scenario, Scenario):
            raise ColonysimError(f"scenario is {SHOWN.repr(scenario)}, expected a scenario, its file or its name")
        scenario = with_robot(scenario)
        self.scenario, self.mode = scenario, mode_of(scenario, mode)
        self._count = scenario.episodes if episodes is None else whole("episodes", episodes)
        self._streams, self._asked = Streams(as_seed(seed)), policy
        self._origin = origin or origin_of(backend, backend_options, policy)
        # As they are now that they are read: whoever loads the colony later gets the same or is told.
        self._files = files_of(scenario.parameters, self._origin.options, scenario.parts_of_groups)
        self._course = Course(scenario)
        self._kinds = _kinds(kinds)
        self._world, self._rows = World(scenario), Rows(scenario, sink, decisions, self._kinds)
        world, rows = self._world, self._rows
        self._tuning: Tuning = {}
        self._sink = sink
        self._take_policies(self._make_policies())
        if isinstance(sink, TraceWriter):
            sink.describe({name: bool(field.by_box) for name, field in self._fields.items()})
        if initial:
            load_fields(world, self._fields, initial)
        made = make_backend(backend, backend_options, scenario)
        refuse_changes(scenario, str(made.name), getattr(made, "changes", ()))
        refuse_unknown_marks(scenario, self._fields)
        check_tunings(scenario, policy, world, rows, self._fields)
        if id(made) in _MOVING:
            raise ColonysimError("this backend moves another colony already; make one for each, or close that one")
        if getattr(made, "tick", None) is not None:
            refuse_speeds(scenario)
        self._body = checked_backend(made, world, rows, recording=sink is not None)
        _MOVING.add(id(made))
        # Also of a colony that nobody closes: an engine keeps what it has until it is told.
        self._release = finalize(self, _let_go, self._body, id(made))
        self._release.atexit = False
        agents = range(len(scenario.agents))
        self._memories: list[Any] = [None for _ in agents]
        self._number, self._running, self._aged, self._closed = 0, False, True, False
        self._calling = self._measuring = False
        self._observers: list[tuple[str, Callable[[Event, Colony], object]]] = []
        self._between: Callable[[], object] | None = None
        self._measures = Measures()
        self._measured: list[Measurement] = []
        try:
            self._set_up()
        except BaseException:
            with suppress(Exception):  # what went wrong first is what counts
                self._release()
            raise

    def _make_policies(self) -> GroupPolicies:
        """The policies that were asked for, with the parameters that hold now."""
        return GroupPolicies(self._asked, tuned(self.scenario, self._tuning), self._world, self._rows)

    def _take_policies(self, policies: GroupPolicies) -> None:
        """Has the agents decide by these policies, and leave marks in their fields."""
        self._policy, self._fields = policies.decider, policies.fields
        self._read, self._unmarked = policies.read_by(), policies.unmarked

    def _set_up(self) -> None:
        """Makes the episode, and what is shown, for the policy and the fields that there are."""
        world, fields, body = self._world, self._fields, self._body
        views = [LocalView(world, self._read[agent], body, agent) for agent in range(len(self._memories))]
        self._episode = Episode(world, fields, body, self._policy, views, self._rows, self._unmarked)
        self._agents, self._boxes = AgentsView(world, self._episode, views), BoxesView(world)
        self._shown_fields, self._place = FieldsView(world, fields), WorldView(world)

    # -- going on ----------------------------------------------------------------------------------------------------

    def step(self) -> Event | None:
        """Goes on to the next event.

        Several events can happen at one moment: an action ends, say, and its agent is at the goal. They are handed
        out one by one, and the colony shows the state after all of them.

        Returns:
            The event; None if all episodes are over, or if an agent is `asked` before another one comes.
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
            time: Until this simulated second of the episode under way, or its end if that is sooner. Everything that is
                due by then has happened. Where no episode is under way, the next one begins.
            event: Until the first event of a kind (see `on`), or for which a function is true.
            episode: Until the episode of this number has ended.

        Returns:
            The last event on the way; None if there was none. It may be less far than asked for where an agent is
            `asked`.

        Raises:
            ColonysimError: Not exactly one of them is given, or what is given cannot be.
        """
        given = [name for name, value in (("time", time), ("event", event), ("episode", episode)) if value is not None]
        if len(given) != 1:
            raise ColonysimError(f"run_until takes one of time, event and episode, not {' and '.join(given) or 'none'}")
        if time is not None:
            return self._run_until_time(real("time", time, 0.0, LONGEST))
        if episode is not None:
            return self._run_until_episode(whole("episode", episode, 1, max(1, self._count)))
        if not callable(event):
            kind = self._observable(event)
            return self._run_until_met(lambda event: _is(kind, event))
        return self._run_until_met(event)

    def _run_until_time(self, time: float) -> Event | None:
        last, events = None, self._rows.events
        while last is None or self._running or events:
            if (came := self._next(time, stay=True)) is None:
                break
            last = came
        if self._running and self._episode.asked < 0:
            self._reach(time)
        return last

    def _run_until_episode(self, number: int) -> Event | None:
        self._observable("episode")
        if self._number > number or (self._number == number and not self._running and not self._rows.events):
            return None
        return self._run_until_met(lambda event: event.kind == "episode" and event.episode >= number)

    def _run_until_met(self, met: Callable[[Event], bool]) -> Event | None:
        last = None
        while (came := self._next(inf)) is not None:
            last = came
            if self._called(met, came):
                break
        return last

    def __iter__(self) -> Iterator[Event]:
        """All events that are still to come."""
        events = self._rows.events
        while events or self._fill(inf):
            while events and not self._observers and not self._calling:
                yield events.pop(0)
            if events:
                self._refuse_calls()
                yield self._told(events.pop(0))

    def _next(self, until: float, *, stay: bool = False) -> Event | None:
        """The next event that is due by a time of the episode under way; None if there is none."""
        self._refuse_calls()
        events = self._rows.events
        return self._told(events.pop(0)) if events or self._fill(until, stay=stay) else None

    def _told(self, event: Event) -> Event:
        for kind, call in self._observers:
            if _is(kind, event):
                self._called(call, event, self)
        return event

    def _called(self, call: Callable[..., Any], *arguments: object) -> Any:
        """What a function of the user returns; it may look at the colony, and what it raises ends it."""
        self._calling = True
        try:
            try:
                return call(*arguments)
            finally:
                self._calling = False
        except BaseException:
            self._fail()
            raise

    def _refuse_calls(self) -> None:
        if self._calling:
            raise ColonysimError("a colony cannot go on while it waits for an observer or a measurement of its own")

    def _fill(self, until: float, *, stay: bool = False) -> bool:
        """Lets the colony go on until events have come out; False if none have by a time of the episode under way.

        Args:
            until: That time.
            stay: Whether to stop at the end of the episode under way, or of the one that begins now.
        """
        self._refuse_calls()
        if self._closed:
            return False
        events, episode, measures = self._rows.events, self._episode, self._measures
        begun = self._running
        try:
            while self._running or (not (stay and begun) and self._begin_next()):
                begun = True
                if events:
                    return True
                came = episode.go_on(until if until < measures.due else measures.due)
                if episode.timeline.tunings:
                    self._tune()
                    episode = self._episode
                if came:
                    return True
                if episode.asked >= 0:
                    return False
                if episode.over:
                    self._finish()
                    if events:
                        return True
                elif episode.paused:
                    if self._between is not None:
                        self._between()
                        episode = self._episode
                elif measures.due <= until:
                    self._reach(measures.due)
                    self._measure(ended=False)
                else:
                    return False
            if self.completed:
                self.close()
        except BaseException:
            self._fail()
            raise
        return False

    def _tune(self) -> None:
        """Has the agents decide by the parameters that the timeline has just set."""
        for change in self._episode.timeline.tunings:
            self._tuning = merged(self._tuning, change)
        adopt(self, self.scenario, tuned=True)

    def _reach(self, time: float) -> None:
        """Nothing more happens up to a time of the episode under way."""
        self._world.now = max(self._world.now, time)

    def _finish(self) -> None:
        """Ends the episode that is over; what is measured at its end comes before its last event is handed out."""
        self._episode.finish()
        self._running = False
        self._measure(ended=True)

    def _begin_next(self) -> bool:
        """Begins the next episode; False if there is none."""
        if not self._aged:  # now, and not with the last event: until then the fields are as the agents left them
            for field in self._fields.values():
                if self.scenario.changes:  # edges come back for the next episode
                    field.settle()
                field.end_episode()
            self._aged = True
        if self._number == self._count:
            return False
        self._course.begin(self)
        self._number += 1
        own = self._streams.within(f"episode/{self._number}")
        self._world.reset()
        self._episode.timeline.prepare(self._number)
        self._body.reset(self._world, own)
        self._memories = [self._policy.begin(agent, memory) for agent, memory in enumerate(self._memories)]
        self._running, self._aged = True, False
        self._measures.begin()
        self._episode.begin(self._number, self._memories, own, synchronous=self.mode == "synchronous")
        return True

    # -- decisions from outside --------------------------------------------------------------------------------------

    @property
    def asked(self) -> int | None:
        """The agent that has to decide now; None while nobody is asked.

        Only of a policy whose decisions come from outside (`colonysim.policies.Outside`). The events up to here may
        not have been handed out yet.
        """
        return self._episode.asked if self._running and self._episode.asked >= 0 else None

    @property
    def asked_together(self) -> list[int]:
        """The agents that decide on the state as it is now, in their order, first the one that is asked.

        In synchronous mode these are all that have not decided yet in this tick, else it is that one alone.
        """
        return [] if self.asked is None else self._episode.asking()

    def view(self, agent: int | None = None) -> LocalView:
        """What an agent can know now; of one that is under way, from where it started. To look changes nothing.

        Args:
            agent: The agent; the one that is asked if None.

        Raises:
            ColonysimError: Nobody is asked, or there is no such agent in the place.
        """
        number = self._whom() if agent is None else whole("agent", agent, 0, len(self._agents) - 1)
        if self._world.agent_status[number] is AgentStatus.ABSENT:
            raise ColonysimError(f"agent {number} is not there")
        view = self._episode.views[number]
        view.look()
        return view

    def choice(self, agent: int | None = None) -> Choice:
        """What the policy itself would have an agent do that has to decide; `answer` takes it.

        It draws from the agent's random stream, so that it is asked once for each decision that follows it.

        Args:
            agent: One of `asked_together`; the one that is asked if None.

        Raises:
            ColonysimError: Nobody is asked, or not this agent.
        """
        first, episode = self._whom(), self._episode
        agent = first if agent is None else agent
        if agent not in self.asked_together:
            raise ColonysimError(f"agent {agent} is not asked for a decision now")
        if agent != first:
            episode.views[agent].look()
        return cast("ForeignPolicy", self._policy).choose(
            episode.views[agent], episode.memories[agent], episode.random[agent]
        )

    def answer(self, given: Choice | Intent, mark: float = 0.0) -> None:
        """Has the agent that is asked do something, after which the colony can go on.

        Args:
            given: What it wants to do; as a `Choice` with what it will remember and what the trace shows of the choice.
            mark: With an intent, what it wants to leave, see `Choice.mark`.

        Raises:
            ColonysimError: Nobody is asked.
            PluginError: It speaks of what does not exist. The agent is still asked.
        """
        agent, episode = self._whom(), self._episode
        choice = given if isinstance(given, Choice) else Choice(given, episode.memories[agent], mark=mark)
        decision = cast("ForeignPolicy", self._policy).taken(agent, choice)
        try:
            self._course.note(self, agent, decision)
            episode.answer(decision)
        except BaseException:
            self._fail()
            raise

    def _whom(self) -> int:
        self._refuse_calls()
        if self._closed or not self._running or self._episode.asked < 0:
            raise ColonysimError("no agent is asked for a decision now: go on until one is (colony.asked)")
        return self._episode.asked

    def interrupt(self) -> None:
        """Ends the episode under way now; its last event, of status "interrupted", is handed out next.

        Raises:
            ColonysimError: It is called by an observer or a measurement.
        """
        if self._calling:
            raise ColonysimError("an episode cannot be ended by an observer or a measurement of its colony")
        if self._running and not self._closed:
            try:
                self._finish()
            except BaseException:
                self._fail()
                raise

    # -- looking on --------------------------------------------------------------------------------------------------

    @property
    def now(self) -> float:
        """Simulated seconds since the start of the episode under way, or how long the last one took."""
        return self._world.now

    @property
    def episode(self) -> int:
        """Number of the episode under way, or of the last one; 0 before the first."""
        return self._number

    @property
    def completed(self) -> bool:
        """Whether all episodes have ended."""
        return self._number == self._count and not self._running

    @property
    def over(self) -> bool:
        """Whether nothing more will be handed out: all episodes have ended, or the colony is closed."""
        return not self._rows.events and (self._closed or self.completed)

    @property
    def pending(self) -> bool:
        """Whether events of the present moment have not been handed out yet."""
        return bool(self._rows.events)

    @property
    def seconds_of_an_edge(self) -> float:
        """Typical simulated seconds of a travelled edge in this episode: the unit of `agents.waited`."""
        return float(self._episode.edge_seconds)

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
        if not callable(call):
            raise ColonysimError(f"on: {SHOWN.repr(call)} is no function of an event and a colony")
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
        self._measures.add(name, call, every, self.now if self._running else 0.0)

    @property
    def measurements(self) -> tuple[Measurement, ...]:
        """What has been measured so far, in order."""
        return tuple(self._measured)

    @property
    def measured(self) -> list[str]:
        """The names of what is measured; of a colony that was loaded, what has been given again."""
        return self._measures.names

    def _measure(self, *, ended: bool) -> None:
        self._measuring = True
        taken = self._called(lambda: [*self._measures.take(self, self._number, self.now, ended=ended)])
        self._measuring = False
        for row in taken:
            self._measured.append(row)
            self._rows.measured(row)

    # -- by hand -----------------------------------------------------------------------------------------------------

    def change(self, item: Mapping[str, Any]) -> Change:
        """Changes something by hand, right after the present moment: as if the scenario's timeline had said so.

        The change becomes the last one of the scenario's timeline, with its episode and time: a run of that scenario
        from its beginning gives the same rows.

        Args:
            item: An entry of `changes:` as in a scenario's file. Without an episode it is meant for the one under way,
                or the next one between two; without a time for the next millisecond in which nothing has happened yet.

        Returns:
            The change, as the timeline has it now; `document` of `scenario` holds it as plain data.

        Raises:
            ColonysimError: It cannot be, or not by hand: agents that join, edges that the file does not know of, a goal
                that it does not name, and on rigid bodies boxes that come or go. Or it would have come already.

        Example:
            ```python
            colony.run_until(time=30)
            colony.change({"policy": {"beta": 1.0}})
            colony.change({"add_box": {"node": 12, "height": 0.35}})
            ```
        """
        self._refuse_calls()
        return change_by_hand(self, item)

    @property
    def changeable(self) -> tuple[str, ...]:
        """The kinds of changes that can be made by hand on this backend."""
        return kinds_by_hand(self)

    @property
    def parameters(self) -> dict[str, Mapping[str, Any]]:
        """The parameters of policies as they hold now, those that are given: by group, "" for the policy of all."""
        now = tuned(self.scenario, self._tuning)
        return {"": now.parameters, **{group.name: now.of_group(n).parameters for n, group in enumerate(now.groups)}}

    # -- keeping and branching ---------------------------------------------------------------------------------------

    def save(self, path: str | Path) -> None:
        """Writes all that the colony is now into a file, from which `load` goes on, in another process too.

        The file (`.npz`, see docs/saving.md) holds plain data: the scenario, the state of every part, and by which
        names backend and policy were asked for. Observers and measurements are functions and not in it.

        Args:
            path: The file; what is there is replaced in one step.

        Raises:
            ColonysimError: The file cannot be written, the colony is closed, or a part of others cannot say its state.
        """
        write_saved(Path(path), saved_of(self))

    @classmethod
    def load(
        cls,
        path: str | Path,
        *,
        scenario: Scenario | str | Path | None = None,
        backend: str | Backend | None = None,
        backend_options: Mapping[str, Any] | None = None,
        policy: str | Policy | Callable[[Scenario], Policy] | None = None,
        sink: Sink | None = None,
        decisions: bool = True,
        kinds: Collection[str] | None = None,
    ) -> Self:
        """A colony that goes on where a saved one has come to, with the same events as if it had never been saved.

        On backends that cannot say their state (rigid bodies) the episode under way is gone through again first,
        without events.

        Args:
            path: The file.
            scenario: What it was made from, if its file names code of others: such is imported only if the caller says
                so himself.
            backend: The backend, if it is code of others or was given as an object; by default the one that was asked
                for then. Others of the same kind will do if they go on from its state.
            backend_options: As for a new colony; by default those that were given then.
            policy: The policy, if it is code of others or was given as an object.
            sink: Takes the rows of the trace that are still to come.
            decisions: As for a new colony.
            kinds: As for a new colony.

        Raises:
            ColonysimError: The file is none of a saved colony, damaged, of another version, or does not fit what else
                is given.
        """
        return loaded(
            cls, Path(path), read_saved(Path(path)), scenario=scenario, backend=backend,
            backend_options=backend_options, policy=policy, sink=sink, decisions=decisions, kinds=kinds,
        )  # fmt: skip

    def fork(
        self,
        seed: int | None = None,
        *,
        overrides: Mapping[str, Any] | Sequence[str] | None = None,
        backend: Backend | None = None,
        sink: Sink | None = None,
        decisions: bool = True,
        kinds: Collection[str] | None = None,
    ) -> Self:
        """Another colony in the state of this one, which goes on by itself: a future to try out.

        Args:
            seed: All that is random from now on is drawn anew from it; None for a twin, which does exactly what this
                one will do.
            overrides: Fields of the scenario to set, as for `load_scenario`: parameters of the policy (`policy.beta`),
                `timing`, `max_steps`, `stall_seconds`, `time_limit` and `episodes`. What is where cannot be changed.
            backend: Moves the fork; needed if this colony's backend was given as an object.
            sink: Takes the rows of the fork's trace from here on.
            decisions: As for a new colony.
            kinds: As for a new colony.

        Raises:
            ColonysimError: A part of others cannot say its state, a field cannot change under way, or a backend is
                missing.

        Example:
            ```python
            colony.run_until(time=60)
            futures = [colony.fork(seed) for seed in range(20)]
            print([future.run_until(event="episode").time for future in futures])
            ```
        """
        saved = saved_of(self)
        refuse_other_files(saved, self.scenario, saved.origin.options)
        if backend is None and saved.origin.options is None:
            raise ColonysimError("fork: this colony's backend was given as an object; give another one, backend=")
        scenario = self._course.scenario if saved.state["course"] else self.scenario
        fork = type(self)(
            scenario, backend=saved.origin.backend if backend is None else backend,
            backend_options=saved.origin.options if backend is None else None, policy=self._asked, mode=saved.mode,
            sink=sink, episodes=saved.episodes, decisions=decisions, kinds=kinds,
        )  # fmt: skip
        with closed_on_error(fork):
            restore(fork, saved.state)
            diverge(fork, None if seed is None else as_seed(seed), overrides)
        return fork

    def _pause(self, call: Callable[[], object], steps: int) -> None:
        """Has a function called between two events, after every so many steps of SimPy without any to hand out."""
        self._between, self._episode.slice, self._episode.pause_at = call, steps, 0

    # -- the end -----------------------------------------------------------------------------------------------------

    def close(self) -> None:
        """Lets go of the backend; a colony that is closed can be looked at, but does not go on. May be called again."""
        if self._calling:
            raise ColonysimError("a colony cannot be closed by an observer or a measurement of its own")
        if self._closed:
            return
        self._closed = True
        self._rows.events.clear()
        try:
            self._release()
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


def _kinds(kinds: Collection[str] | None) -> frozenset[str] | None:
    if kinds is None:
        return None
    if isinstance(kinds, str) or not isinstance(kinds, Iterable):
        raise ColonysimError(f"kinds is {kinds!r}, expected a list of kinds, such as ['goal', 'episode']")
    asked = [*kinds]
    for kind in asked:
        if kind not in EVENT_KINDS:
            raise ColonysimError(f"kinds: no events of kind {kind!r}; {nearest(str(kind), EVENT_KINDS)}")
    return frozenset(asked)


def _let_go(body: Backend, number: int) -> None:
    _MOVING.discard(number)
    body.close()


def _event_kind(kind: str) -> str:
    return "end" if kind in ("arrive", "fail") else kind


def _is(kind: str, event: Event) -> bool:
    """Whether an event is what `Colony.on` was asked for."""
    if kind in ("arrive", "fail"):
        return event.kind == "end" and (event.status == "arrived") == (kind == "arrive")
    return event.kind == kind
