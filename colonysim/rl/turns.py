"""A colony as a game of turns: who is asked, what that agent sees and can do, and what it is paid."""

from __future__ import annotations

import copy
import operator
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from colonysim.arguments import MAX_SEED, as_seed, whole
from colonysim.errors import ColonysimError
from colonysim.policies import Choice, Outside
from colonysim.randomness import Streams
from colonysim.rl.options import DEFAULTS, WORDS
from colonysim.rl.picture import picture
from colonysim.rl.recorded import begin_run
from colonysim.rl.rewards import KINDS, Stretch, reward_of
from colonysim.rl.spaces import Observer
from colonysim.scenario.loading import load_scenario
from colonysim.scenario.scenario import Scenario
from colonysim.simulation import Colony
from colonysim.suggest import nearest
from colonysim.world.intents import Push, Travel, Wait

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from typing import Self

    from numpy.typing import NDArray

    from colonysim.rl.options import Options
    from colonysim.rl.sight import Sight
    from colonysim.rl.spaces import Observation
    from colonysim.trace.schema import Event
    from colonysim.trace.writer import TraceWriter
    from colonysim.world.intents import Intent

__all__ = ["Action", "Turns", "name_of"]

_INTENTS = (Choice, Travel, Push, Wait)
MOST_ROWS = 10_000
"""Rows of neighbours, of boxes and of holes in an observation, at most."""
Action = int | np.integer[Any] | Choice | Travel | Push | Wait
"""A number of the action space, or what a policy of this package answers."""
ENDING = ("goal", "lost", "spent")
"""Events that end an agent's episode before that of the colony."""
TERMINAL = ("goal", "lost")
"""Ends of an agent's episode after which nothing is to be expected any more; all others cut it off."""


def name_of(agent: int) -> str:
    """What an agent is called in environments."""
    return f"robot_{agent}"


class Turns:
    """A colony whose decisions come from whoever holds this; all environments are thin doors onto it.

    Agents are numbers here.

    Args:
        scenario: The place: a scenario, the path of its file, or the name of one that comes with the package.
        busy: Whether there is an action to do nothing, for agents that are not asked.
        **options: See `Options`.

    Attributes:
        scenario: The scenario.
        options: All options.
        reward: The reward.
        seed: The seed of the run under way.
        episodes: How many episodes a run has.
        colony: The colony of the episode under way; None before the first.
        observer: Makes the arrays.
        agents: The agents that take part in the episode, in order.
        ends: How the episode has ended for each agent that it has ended for: "goal", "lost", "max_steps", "deadlock",
            "timeout" or "interrupted".
        paid: What each agent was paid for the last stretch.
        begin: When the last stretch began, simulated seconds.
        end: When it ended.

    Raises:
        ColonysimError: Something that is asked for does not exist or does not fit.
    """

    def __init__(self, scenario: Scenario | str | Path, *, busy: bool = False, **options: Unpack[Options]) -> None:
        for name in options:
            if name not in DEFAULTS:
                raise ColonysimError(f"an environment has no option {name!r}; {nearest(name, DEFAULTS)}")
        given: Options = {**DEFAULTS, **options}
        for name, words in WORDS.items():
            if given[name] not in words:  # type: ignore[literal-required]
                raise ColonysimError(f"{name}: no {given[name]!r}; {nearest(str(given[name]), words)}")  # type: ignore[literal-required]
        if not isinstance(scenario, Scenario):
            scenario = load_scenario(scenario, given["variant"], given["overrides"])
        elif given["variant"] is not None or given["overrides"]:
            raise ColonysimError("variant and overrides: the scenario is loaded already; give its path or name")
        self.scenario, self.options, self.reward = scenario, given, reward_of(given["reward"])
        self._seed, self._runs = as_seed(given["seed"]), 0
        self.seed = self._seed
        self._keep, self._marks = given["pheromones"] == "keep", given["deposits"] == "action"
        if given["half_life"] is not None and not self._marks:
            raise ColonysimError("half_life: only of marks that actions leave: deposits='action'")
        self.episodes = scenario.episodes if self._keep else 1
        self._kinds = None if callable(given["reward"]) else KINDS
        self.colony: Colony | None = None
        self._writer: TraceWriter | None = None
        self._trace = None if given["trace"] is None else Path(given["trace"])
        self._written = 0
        with Colony(scenario, policy=self._policy(), kinds=()) as colony:
            by_box = {name: field.by_box for name, field in colony.fields.items()}
        most = given["neighbours"]
        self.observer = Observer(
            scenario, by_box, parts=tuple(given["parts"]), flat=given["flat"],
            boxes=whole("boxes", given["boxes"], 0, MOST_ROWS),
            holes=whole("holes", given["holes"], 0, MOST_ROWS), by_action=given["hole"] == "action",
            neighbours=None if most is None else whole("neighbours", most, 1, MOST_ROWS), marks=self._marks, busy=busy,
        )  # fmt: skip
        self._clear()

    def _policy(self) -> Callable[[Scenario], Outside]:
        return Outside.over(self.options["policy"], signal=self._marks, half_life=self.options["half_life"])

    def _clear(self) -> None:
        count = len(self.scenario.agents)
        self.agents: list[int] = []
        self.ends: dict[int, str] = {}
        self.paid = [0.0] * count
        self.begin, self.end, self.edge_seconds = 0.0, 0.0, 1.0
        self._there = [False] * count
        self._last, self._why, self._illegal = [""] * count, [""] * count, [False] * count
        self._since, self._until = [0.0] * count, dict[int, float]()
        self._full: set[int] = set()
        self._arrived, self._under_way = 0, False
        self._seen: tuple[int, Sight] | None = None

    # -- episodes ------------------------------------------------------------------------------------------------------

    def reset(self, seed: int | None = None) -> None:
        """Begins the next episode, and goes on to its first question.

        Args:
            seed: Begins a new run: the same seed gives the same episodes again. None for the next episode of the run
                or, if that is over, for the next run.
        """
        if seed is not None:
            self._leave()
            self._seed, self._runs = as_seed(seed), 0
        elif self.colony is not None:
            self._interrupt()
            if not self._keep or self.colony.completed or self.colony.over:
                self._leave()
        if self.colony is None:
            self._begin_run()
        self._clear()
        self._begin_episode()

    def _begin_run(self) -> None:
        given, seed = self.options, self._seed
        if self._runs:
            seed = Streams(self._seed).derive(f"run/{self._runs}") % (MAX_SEED + 1)
        self._runs += 1
        self.seed = seed
        if self._trace is not None:
            self._written += 1
            self._writer = begin_run(
                self._trace / f"run-{self._written:06d}", self.scenario, backend=given["backend"],
                backend_options=given["backend_options"], policy=given["policy"], mode=given["mode"],
                episodes=self.episodes, seed=seed,
            )  # fmt: skip
        try:
            self.colony = Colony(
                self.scenario, backend=given["backend"], backend_options=given["backend_options"], kinds=self._kinds,
                policy=self._policy(), mode=given["mode"], episodes=self.episodes, seed=seed, sink=self._writer,
                decisions=self._writer is not None and "decisions" in self._writer.manifest["recorded"]["tables"],
            )  # fmt: skip
        except BaseException:
            self._finish_run("failed")
            raise

    def _begin_episode(self) -> None:
        colony = self._held()
        self._under_way, first = True, self._next(colony)
        shown = colony.agents
        self.agents = shown.takes_part.nonzero()[0].tolist()
        self._there = [status != "absent" for status in shown.status.tolist()]
        self.edge_seconds = colony.seconds_of_an_edge
        self._full = set(colony.world.holes[colony.world.filled].tolist())
        self._advance([] if first is None else [first])

    def close(self) -> None:
        """Lets go of the colony; an episode under way ends as "interrupted"."""
        self._leave()

    def _leave(self) -> None:
        """Ends the run under way."""
        if self.colony is None:
            return
        if self._writer is not None:
            self._interrupt()
        colony, self.colony, self._seen = self.colony, None, None
        try:
            colony.close()
        finally:
            if self._writer is not None:
                ends = [result.ended for result in self._writer.results]
                done = len(ends) == self.episodes and ends[-1] != "interrupted"
                self._finish_run("finished" if done else "interrupted")

    def _interrupt(self) -> None:
        """Ends the episode under way."""
        if not self._under_way:
            return
        self._under_way, colony = False, self._held()
        colony.interrupt()
        while (event := self._next(colony)) is not None:
            if event.kind == "episode":
                break

    def _finish_run(self, status: str) -> None:
        writer, self._writer = self._writer, None
        if writer is not None:
            writer.finish(status)

    def _held(self) -> Colony:
        if self.colony is None:
            raise ColonysimError("no episode is under way: call reset first")
        return self.colony

    def _next(self, colony: Colony) -> Event | None:
        try:
            return colony.step()
        except BaseException:
            self._fail()
            raise

    def _fail(self) -> None:
        """Lets go of a colony that has failed."""
        self.colony = None
        self._finish_run("failed")

    # -- turns ---------------------------------------------------------------------------------------------------------

    @property
    def asked(self) -> int | None:
        """The agent that has to decide; None if the episode is over."""
        return None if self.colony is None else self.colony.asked

    @property
    def together(self) -> list[int]:
        """The agents that decide on the same state, in their order: all of a tick in synchronous mode, else one."""
        return [] if self.colony is None else self.colony.asked_together

    def answer(self, action: Action) -> None:
        """Has the agent that is asked act, and goes on to the next question or the end of the episode.

        Args:
            action: A number of the action space, or a `Choice` or an intent.

        Raises:
            ColonysimError: Nobody is asked, there is no such action, or it is not allowed and `illegal` is "raise".
        """
        self.decide(action)
        self.go_on()

    def decide(self, action: Action) -> None:
        """`answer` without going on."""
        colony = self._held()
        if (agent := colony.asked) is None:
            raise ColonysimError("the episode is over: call reset")
        self._take(colony, agent, self._given(agent, action))

    def _take(self, colony: Colony, agent: int, given: tuple[Choice | Intent, float, bool]) -> None:
        """Takes the decision of the agent that is asked, as `_given` has read it."""
        decision, mark, illegal = given
        colony.answer(decision, mark)
        self._since[agent], self._illegal[agent], self._seen = colony.now, illegal, None

    def decide_together(self, actions: Mapping[str, Action]) -> None:
        """Has all agents act that decide on the same state; one that is given nothing to do waits for one edge's time.

        Args:
            actions: By name of an agent; those of others are left aside.

        Raises:
            ColonysimError: One is no action, or is not allowed; then no agent has decided.
        """
        colony = self._held()
        if not isinstance(actions, Mapping):
            raise ColonysimError(f"{actions!r} holds no actions; expected a mapping from the names of agents")
        pause = self.observer.moves.pause
        for agent, given in [(a, self._given(a, actions.get(name_of(a), pause))) for a in self.together]:
            self._take(colony, agent, given)

    def _given(self, agent: int, action: Any) -> tuple[Choice | Intent, float, bool]:
        """The decision that an action means, the mark that it leaves, and whether it is not allowed."""
        if isinstance(action, _INTENTS):
            return action, 0.0, False
        observer, number = self.observer, _whole(action)
        if number is None:
            raise ColonysimError(f"agent {agent}: {action!r} is no action; expected a number, a Choice or an intent")
        if not 0 <= number < observer.actions:
            raise ColonysimError(f"agent {agent}: no action {number}; expected one from 0 to {observer.actions - 1}")
        sight = self.sight(agent)
        legal = number < observer.moves.count and sight.mask[number] == 1
        if not legal and self.options["illegal"] == "raise":
            raise ColonysimError(f"agent {agent}: action {number} is not allowed now, see the mask of actions")
        if not legal:
            number = observer.moves.pause
        intent = sight.intent(number)
        assert intent is not None
        return intent, float(number >= observer.moves.moves), not legal

    def go_on(self) -> None:
        """Goes on to the next question, or to the end of the episode."""
        self.begin = self._held().now
        self._advance([])

    def _advance(self, events: list[Event]) -> None:
        colony = self._held()
        if not (events and events[-1].kind == "episode"):
            self._gather(colony, events)
        self.paid, self.end = [0.0] * len(self._there), colony.now
        begun, now = 0, self.begin
        for number, event in enumerate(events):
            if event.kind == "end":
                self._last[event.agent], self._why[event.agent] = event.status, event.reason
            elif event.kind == "start":
                self._there[event.agent] = True
            elif event.kind in ENDING:
                self._pay(events[begun : number + 1], now, event.time)
                begun, now = number + 1, event.time
                self._end(event)
        self._pay(events[begun:], now, self.end)
        if events and events[-1].kind == "episode":
            self._under_way = False
            for agent in self.agents:
                self._until.setdefault(agent, self.end)
                self.ends.setdefault(agent, events[-1].status)

    def _gather(self, colony: Colony, events: list[Event]) -> None:
        """Adds what happens up to the next question, or the end of the episode."""
        try:
            for event in colony:
                events.append(event)
                if event.kind == "episode":
                    break
        except BaseException:
            self._fail()
            raise

    def _end(self, event: Event) -> None:
        """The episode has ended for an agent."""
        agent = event.agent
        self._until[agent], self.ends[agent] = event.time, "max_steps" if event.kind == "spent" else event.kind
        self._there[agent] = event.kind == "spent"
        self._arrived += event.kind == "goal"

    def _pay(self, events: Sequence[Event], begin: float, end: float) -> None:
        """Pays the agents for a stretch whose end is a decision, or the end of an agent's episode."""
        if end == begin and not events:
            return
        colony, filled = self._held(), []
        if "push" in [event.action for event in events if event.kind == "end"]:
            full = set(colony.world.holes[colony.world.filled].tolist())
            filled, self._full = sorted(full - self._full), full
        stretch = Stretch(
            events, begin, end, self.edge_seconds, len(self.agents), self._arrived, self._there, filled, colony
        )
        paid, ends = self.paid, self.ends
        for agent, value in enumerate(self.reward(stretch)):
            if agent not in ends:
                paid[agent] += value

    def fork(self, seed: int | None = None) -> Self:
        """Another game in the same state, which goes on by itself and is not recorded; see `Colony.fork`."""
        twin = copy.copy(self)
        twin._writer = twin._trace = None
        twin._there, twin._last, twin._why = self._there[:], self._last[:], self._why[:]
        twin._illegal, twin._since, twin._full = self._illegal[:], self._since[:], set(self._full)
        twin._until = dict(self._until)
        twin.agents, twin.ends, twin.paid, twin._seen = self.agents[:], dict(self.ends), self.paid[:], None
        twin.colony = None
        if self.colony is not None and not self.colony.over:
            twin.colony = self.colony.fork(seed, kinds=self._kinds)
        return twin

    def choice(self, agent: int | None = None) -> Choice:
        """What the policy, whose marks the agents leave, would have an agent do that has to decide; `answer` takes it.

        It draws from the agent's random stream: ask it once for each decision that follows it.

        Args:
            agent: One of `together`; the one that is asked first if None.

        Raises:
            PluginError: It goes by marks, and those are not left here (`deposits`).
        """
        return self._held().choice(agent)

    # -- what agents are told ------------------------------------------------------------------------------------------

    def sight(self, agent: int) -> Sight:
        """What an agent sees."""
        if self._seen is None or self._seen[0] != agent:
            self._seen = (agent, self.observer.sight(self._held().view(agent)))
        return self._seen[1]

    def asks(self, agent: int) -> bool:
        """Whether it is an agent's turn."""
        colony = self.colony
        return colony is not None and (agent == colony.asked or agent in colony.asked_together)

    def observe(self, agent: int) -> tuple[NDArray[np.float32], NDArray[np.int8]]:
        """The numbers that an agent is told, and the mask of its actions."""
        observer, colony = self.observer, self.colony
        if colony is None or not self._there[agent]:
            return observer.nothing(), observer.mask(None)
        sight, asks = self.sight(agent), self.asks(agent)
        if agent != colony.asked:
            self._seen = None  # it may change before this agent is asked
        return observer.numbers(sight), observer.mask(sight if asks else None)

    def observation(self, agent: int) -> Observation:
        """The observation of an agent."""
        return self.observer.observation(*self.observe(agent))

    def mask(self, agent: int) -> NDArray[np.int8]:
        """The mask of an agent's actions."""
        return self.observer.mask(self.sight(agent) if self.asks(agent) else None)

    def info(self, agent: int, since: float, mask: NDArray[np.int8]) -> dict[str, Any]:
        """What is told besides: the time, how long it took, and how the agent's last move came out.

        The time of an agent whose episode has ended is that of its end.

        Args:
            agent: The agent.
            since: The time from which `dt` counts, simulated seconds.
            mask: The mask of its actions.
        """
        now = self._until.get(agent, self.end)
        found = {
            "t": now, "dt": now - since, "outcome": self._last[agent],
            "reason": self.ends.get(agent) or self._why[agent], "action_mask": mask,
        }  # fmt: skip
        if self._illegal[agent]:
            found["illegal"] = True
        return found

    def since(self, agent: int) -> float:
        """When an agent decided last, simulated seconds; 0 if it never has."""
        return self._since[agent]

    def over(self, agent: int) -> tuple[bool, bool]:
        """Whether the episode has terminated for an agent, and whether it was truncated."""
        end = self.ends.get(agent)
        return end in TERMINAL, end is not None and end not in TERMINAL

    def state(self) -> NDArray[np.float32]:
        """All that is so, for a critic that may know it: time, agents, boxes, nodes, and pheromones at the nodes."""
        colony = self._held()
        agents, boxes, world = colony.agents, colony.boxes, colony.world
        status = agents.status
        parts = [
            [colony.now / self.edge_seconds], agents.position[:, :2], agents.held_box, agents.steps, agents.waited,
            *(status == word for word in ("active", "goal", "spent", "lost")), np.nan_to_num(boxes.position),
            boxes.holder, world.surface, world.occupant,
            *(self._at_nodes(colony, name) for name in self.observer.names),
        ]  # fmt: skip
        return np.concatenate([np.asarray(part, np.float32).ravel() for part in parts])

    def picture(self) -> NDArray[np.uint8]:
        """The colony from above, see `colonysim.rl.picture`."""
        return picture(self._held())

    def _at_nodes(self, colony: Colony, name: str) -> NDArray[np.float32]:
        """The largest value of a field at each node."""
        found = dict.fromkeys(colony.world.node.tolist(), 0.0)
        for (node, _), value in colony.fields[name].items().items():
            found[node] = max(found[node], value)
        return np.array([*found.values()], np.float32)

    @property
    def state_size(self) -> int:
        """How many numbers `state` has."""
        scenario = self.scenario
        nodes = len(scenario.topology)
        return 1 + 9 * len(scenario.agents) + 4 * len(scenario.boxes) + nodes * (2 + len(self.observer.names))


def _whole(action: Any) -> int | None:
    """An action as a number; None for what is no whole number."""
    try:
        return None if isinstance(action, (bool, np.bool_)) else operator.index(action)
    except TypeError:
        return None
