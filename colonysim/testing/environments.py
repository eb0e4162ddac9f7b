"""Does an environment of a colony keep its promises over whole episodes? A check for those who derive or wrap one."""

from __future__ import annotations

import random
import warnings
from contextlib import redirect_stdout
from io import StringIO
from itertools import zip_longest
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from colonysim.arguments import as_seed, whole
from colonysim.errors import ColonysimError
from colonysim.policies.outside import Outside
from colonysim.policies.policy import Choice
from colonysim.rl.rewards import Stretch
from colonysim.simulation import Colony
from colonysim.testing.policies import change_what_is_hidden
from colonysim.testing.promises import ConformanceError
from colonysim.world.intents import Wait

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from colonysim.pheromones.field import Field
    from colonysim.policies.view import LocalView
    from colonysim.rl import ColonyAEC, ColonyParallel
    from colonysim.world.intents import Intent
    from colonysim.world.state import World

__all__ = ["check_env"]

EVERY = 7
"""Each so many questions one is taken apart: every action is tried in a fork."""
CLOSE = 1e-6
"""Sums of rewards and times may differ by so much, relative to their size."""
STREAM = "environment/{}"


def check_env(
    factory: Callable[[], ColonyAEC | ColonyParallel], *, episodes: int = 2, seed: int = 1, api: bool = True
) -> None:
    """Plays whole episodes by random allowed actions, and looks at everything that the environment says.

    Of a parallel environment copies and locality are not looked at: its class has them from the same game of turns.

    Args:
        factory: Makes the environment, or one that is derived from it.
        episodes: How many episodes are played in a row.
        seed: Of those episodes; of the random actions too.
        api: Whether PettingZoo's own tests are run as well.

    Raises:
        ConformanceError: The first broken promise: "PettingZoo's tests", "spaces", "who is asked", "masks", "time",
            "rewards", "seeds", "determinism", "locality", "native run" or "copies"; the message says what happened.

    Example:
        ```python
        from colonysim import rl
        from colonysim.testing import check_env

        def test_my_environment_keeps_its_promises():
            check_env(lambda: rl.aec("hard", reward="own_time"))
        ```
    """
    episodes, seed = whole("episodes", episodes), as_seed(seed)
    first = _play(factory(), seed, episodes, _Watch())
    _same("determinism", f"seed {seed}", _play(factory(), seed, episodes), first)
    for other in (seed, seed + 1):  # whatever was played before must not matter
        env = factory()
        _play(env, seed + 2, 1, close=False)
        expected = first if other == seed else _play(factory(), other, episodes)
        _same("seeds", f"seed {other} after another", _play(env, other, episodes), expected)
    env = factory()
    for run in dict.fromkeys(turn.seed for turn in first):
        _check_native(env, [turn for turn in first if turn.seed == run])
    if not _is_parallel(env):
        _check_copies(factory, seed, [turn for turn in first if turn.episode == 0])
    env.close()
    if api:
        _check_api(factory)


# -- PettingZoo's tests ------------------------------------------------------------------------------------------------


def _check_api(factory: Callable[[], Any]) -> None:
    from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test, seed_test

    env = factory()
    tests = (parallel_api_test, parallel_seed_test) if _is_parallel(env) else (api_test, seed_test)
    try:
        with warnings.catch_warnings(), redirect_stdout(StringIO()):
            warnings.simplefilter("ignore")  # what it advises of: spaces that are dicts, and the like
            tests[0](env, num_cycles=60)
            tests[1](factory, num_cycles=40)
    except ColonysimError:
        raise
    except Exception as error:
        raise ConformanceError("PettingZoo's tests", f"{type(error).__name__}: {error}") from error


def _is_parallel(env: Any) -> bool:
    return not hasattr(env, "agent_iter")


# -- playing -----------------------------------------------------------------------------------------------------------


class _Turn(NamedTuple):
    """What was said to an agent and what it did: at a question, or (`action` None) at the end of its episode."""

    seed: int
    episode: int
    agent: int
    time: float
    since: float
    observation: Any
    mask: tuple[int, ...]
    reward: float
    action: int | None
    intent: Intent | None
    ended: tuple[bool, bool]
    reason: str


Chooser: TypeAlias = "Callable[[Any, Sequence[int]], int]"
"""Chooses an action from an environment and the mask of the agent that is asked."""


def _play(env: Any, seed: int, episodes: int, watch: _Watch | None = None, *, close: bool = True) -> list[_Turn]:
    """Episodes of random allowed actions; the environment is closed at the end, or if something is wrong."""
    stream, found = random.Random(STREAM.format(seed)), list[_Turn]()

    def drawn(env: Any, mask: Sequence[int]) -> int:
        return _drawn(env, mask, stream)

    try:
        for episode in range(episodes):
            given = seed if episode == 0 else None
            if _is_parallel(env):
                told = env.reset(seed=given)
                found += _parallel_turns(env, told, episode, drawn, watch)
            else:
                env.reset(seed=given)
                found += _turns(env, episode, drawn, watch)
    except BaseException:
        env.close()
        raise
    if close:
        env.close()
    return found


def _turns(env: Any, episode: int, choose: Chooser, watch: _Watch | None = None) -> Iterator[_Turn]:
    """The rest of an episode."""
    while env.agents:
        turn = _read(env, episode, choose)
        if watch is not None:
            watch.look(env, turn)
        yield turn
        env.step(turn.action)


def _read(env: Any, episode: int, choose: Chooser) -> _Turn:
    """What is said to the agent whose turn it is, and what it will do."""
    observation, reward, terminated, truncated, info = env.last()
    agent = env.possible_agents.index(env.agent_selection)
    return _turn(env, episode, agent, observation, reward, (terminated, truncated), info, choose)


def _parallel_turns(
    env: Any, told: tuple[Any, Any], episode: int, choose: Chooser, watch: _Watch | None = None
) -> Iterator[_Turn]:
    """The rest of an episode, whose last observations and infos are given."""
    observations, infos = told
    number = {name: agent for agent, name in enumerate(env.possible_agents)}
    owed: dict[str, float] = dict.fromkeys(number, 0.0)
    last = dict.fromkeys(number, 0.0)
    while env.agents:
        actions = {}
        for name in env.agents:
            if not infos[name]["requires_decision"]:
                if sum(infos[name]["action_mask"]) != 1 or not infos[name]["action_mask"][-1]:
                    raise ConformanceError("masks", f"{name} is busy, but its mask allows {infos[name]['action_mask']}")
                continue
            info = {**infos[name], "dt": infos[name]["t"] - last[name]}
            turn = _turn(env, episode, number[name], observations[name], owed[name], (False, False), info, choose)
            if watch is not None:
                watch.look(env, turn)
            yield turn
            actions[name], owed[name], last[name] = turn.action, 0.0, infos[name]["t"]
        before = [*env.agents]
        observations, rewards, terminated, truncated, infos = env.step(actions)
        for name in before:
            owed[name] += rewards[name]
            if terminated[name] or truncated[name]:
                info = {**infos[name], "dt": infos[name]["t"] - last[name]}
                ended = (terminated[name], truncated[name])
                yield _turn(env, episode, number[name], observations[name], owed[name], ended, info, choose)


def _turn(
    env: Any, episode: int, agent: int, observation: Any, reward: float, ended: tuple[bool, bool], info: Any,
    choose: Chooser,
) -> _Turn:  # fmt: skip
    mask = observation["action_mask"] if isinstance(observation, dict) else info["action_mask"]
    action = None if any(ended) else choose(env, mask)
    intent = None if action is None else _intent(env, agent, action)
    return _Turn(
        env.turns.seed, episode, agent, info["t"], info["t"] - info["dt"], _frozen(observation), tuple(map(int, mask)),
        float(reward), action, intent, ended, info["reason"],
    )  # fmt: skip


def _drawn(env: Any, mask: Sequence[int], stream: random.Random) -> int:
    """An allowed action; waits seldom, or episodes would be long."""
    allowed, moves = [action for action, can in enumerate(mask) if can], env.turns.observer.moves
    allowed = allowed or [moves.pause]
    going = [action for action in allowed if action < moves.wait]
    chosen = going if going and stream.random() < 0.95 else allowed
    return chosen[int(stream.random() * len(chosen))]


def _intent(env: Any, agent: int, action: int) -> Intent | None:
    """What an action means, found anew from the agent's view."""
    found: Intent | None = env.turns.observer.sight(env.turns.colony.view(agent)).intent(action)
    return found


def _frozen(observation: Any) -> Any:
    if isinstance(observation, dict):
        return tuple((part, observation[part].tobytes()) for part in sorted(observation))
    return observation.tobytes()


def _same(promise: str, what: str, found: Sequence[_Turn], expected: Sequence[_Turn]) -> None:
    for one, other in zip(found, expected, strict=False):
        for name in _Turn._fields:
            if getattr(one, name) != getattr(other, name):
                shown = "" if name == "observation" else f": {getattr(other, name)!r} and then {getattr(one, name)!r}"
                where = f"episode {one.episode + 1}, agent {one.agent} at {one.time:g} s"
                raise ConformanceError(promise, f"{what} gives another episode the second time; {where}, {name}{shown}")
    if len(found) != len(expected):
        raise ConformanceError(promise, f"{what}: {len(expected)} turns and then {len(found)}")


# -- while it is played ------------------------------------------------------------------------------------------------


class _Watch:
    """Looks at each turn while it is there."""

    def __init__(self) -> None:
        self._asked, self._at = 0, dict[tuple[int, int], float]()
        self._stream = random.Random(STREAM.format("hidden"))

    def look(self, env: Any, turn: _Turn) -> None:
        """Checks one turn.

        Raises:
            ConformanceError: Something about it is wrong.
        """
        name, colony = env.possible_agents[turn.agent], env.turns.colony
        if not _is_parallel(env):
            observation = env.last()[0]
            if not env.observation_space(name).contains(observation):
                raise ConformanceError("spaces", f"the observation of {name} is none of its space: {observation}")
        if len(turn.mask) != env.action_space(name).n:
            raise ConformanceError("spaces", f"the mask of {name} has {len(turn.mask)} actions")
        status = colony.agents.status[turn.agent]
        if turn.action is not None and (status != "active" or turn.agent not in colony.asked_together):
            raise ConformanceError("who is asked", f"{name}, which is {status!r}; the colony asks {colony.asked}")
        key, now = (turn.episode, turn.agent), colony.now
        late = turn.time > now if turn.action is None else abs(turn.time - now) > CLOSE
        if late or abs(turn.since - self._at.get(key, 0.0)) > CLOSE:
            raise ConformanceError(
                "time",
                f"{name} is told t = {turn.time:g} s and dt = {turn.time - turn.since:g} s at {now:g} s; it decided "
                f"last at {self._at.get(key, 0.0):g} s",
            )
        if turn.action is None:
            return
        self._at[key] = now
        fresh = env.turns.observer.mask(env.turns.observer.sight(colony.view(turn.agent)))
        if tuple(fresh.tolist()) != turn.mask:
            raise ConformanceError("masks", f"{name} at {now:g} s is shown {turn.mask}, but it can {fresh.tolist()}")
        self._asked += 1
        if self._asked % EVERY == 0 and turn.agent == colony.asked:
            if not colony._episode.ticks.decided:  # else others have decided already, and may get there first
                _try_all(env, turn)
            if hasattr(env, "observe"):
                _hide(env, self._stream)


def _try_all(env: Any, turn: _Turn) -> None:
    """Tries every action in a fork: those that are allowed start and come to something, no other does."""
    colony, moves = env.turns.colony, env.turns.observer.moves
    quick = colony._body.tick is None
    for action in range(moves.wait):
        intent = _intent(env, turn.agent, action)
        if intent is None:
            if turn.mask[action]:
                raise ConformanceError("masks", f"action {action} of agent {turn.agent} is allowed, but means nothing")
            continue
        if not quick and not turn.mask[action]:
            continue  # rigid bodies may well do what nobody would try
        twin = colony.fork()
        try:
            started, arrived = _tried(twin, turn.agent, intent, quick)
        finally:
            twin.close()
        works = started and arrived
        if quick and works != bool(turn.mask[action]):
            what = "is allowed, but does not work" if turn.mask[action] else "is forbidden, but works"
            who = f"action {action} of agent {turn.agent} at {turn.time:g} s"
            raise ConformanceError("masks", f"{who} {what}: {intent}")


def _tried(twin: Colony, agent: int, intent: Intent, wait_for_it: bool) -> tuple[bool, bool]:
    """Whether a move begins, and whether it arrives."""
    before = twin.agents.steps_of(agent)
    twin.answer(intent)
    while twin.asked is not None and twin.mode == "synchronous" and twin.agents.steps_of(agent) == before:
        others = twin.asked_together
        twin.answer(Wait())
        if len(others) == 1:
            break
    if twin.agents.steps_of(agent) == before:
        return False, False
    while wait_for_it and (event := twin.step()) is not None:
        if event.kind == "end" and event.agent == agent:
            return True, event.status == "arrived"
        if twin.asked is not None and not twin._rows.events:
            twin.answer(Wait((), 1.0))
    return True, True


def _hide(env: Any, stream: random.Random) -> None:
    """Changes in a fork what an agent cannot know: what it is told must stay the same."""
    if env.turns.colony._body.tick is not None:
        return
    number = {name: agent for agent, name in enumerate(env.possible_agents)}
    for name in env.agents:
        agent = number[name]
        if env.turns.colony.agents.status[agent] != "active":
            continue
        twin = env.fork()
        try:
            _blur(twin, agent, stream)
            if _frozen(twin.observe(name)) != _frozen(env.observe(name)):
                raise ConformanceError(
                    "locality", f"what {name} is told at {env.turns.colony.now:g} s changes with what it cannot know"
                )
        finally:
            twin.close()


def _blur(env: Any, agent: int, stream: random.Random) -> None:
    view: LocalView = env.turns.colony.view(agent)
    world, colony = view._world, env.turns.colony
    kept = world.scenario, world.topology
    # The map is shared with the colony that was forked, so only what belongs to this one may change.
    change_what_is_hidden(view, stream, terrain=False)
    assert kept == (world.scenario, world.topology)
    for other in range(len(colony.agents)):
        if other != agent:
            own = colony._episode.views[other]
            own.waited, own.failures = own.waited + stream.uniform(1.0, 5.0), own.failures + 1


# -- beside the native run ---------------------------------------------------------------------------------------------


class _Script:
    """A policy that does by itself what was done, and notes who was asked when."""

    outside = False

    def __init__(self, turns: Any, played: Sequence[_Turn]) -> None:
        self._policy = Outside(turns.scenario, turns.options["policy"])
        self._left = [turn for turn in played if turn.action is not None]
        self._next = dict.fromkeys(range(len(turns.scenario.agents)), 0)
        self.name, self.asked = self._policy.name, list[tuple[int, float]]()
        self.colony: Colony | None = None

    def fields(self, world: World) -> Mapping[str, Field]:
        return self._policy.fields(world)

    def begin(self, agent: int, memory: Any) -> Any:
        return self._policy.begin(agent, memory)

    def decide(self, view: LocalView, memory: Any, random: random.Random) -> Choice:
        agent = view.agent
        self.asked.append((agent, self.colony.now if self.colony is not None else 0.0))
        for at in range(self._next[agent], len(self._left)):
            if self._left[at].agent == agent and (intent := self._left[at].intent) is not None:
                self._next[agent] = at + 1
                return Choice(intent, memory)
        return Choice(Wait((), view.edge_seconds), memory)


def _check_native(env: Any, played: Sequence[_Turn]) -> None:
    """Plays a run again without the environment, and compares who was asked when, and what was paid."""
    turns, count = env.turns, len({turn.episode for turn in played})
    options, script = turns.options, _Script(turns, played)
    asked = [(turn.agent, turn.time) for turn in played if turn.action is not None]
    with Colony(
        turns.scenario, policy=script, backend=options["backend"], backend_options=options["backend_options"],
        mode=options["mode"], episodes=max(count, turns.episodes), seed=played[0].seed,
    ) as colony:  # fmt: skip
        script.colony = colony
        paid, ends = [], []
        for _ in range(count):
            totals, until = _episode(colony, turns)
            paid.append(totals)
            ends.append(until)
    order = _by_time if _is_parallel(env) else list  # there all that decide on one state are asked at once
    for number, (found, native) in enumerate(zip_longest(order(asked), order(script.asked))):
        if found != native:
            raise ConformanceError(
                "native run",
                f"question {number + 1} goes to (agent, simulated seconds) {found}, in the native run to {native}",
            )
    for number, episode in enumerate(dict.fromkeys(turn.episode for turn in played)):
        own = [turn for turn in played if turn.episode == episode]
        for turn in own:
            if turn.action is None and abs(turn.time - ends[number].get(turn.agent, ends[number][-1])) > CLOSE:
                raise ConformanceError(
                    "time", f"the end of episode {episode + 1} for agent {turn.agent} is said to be at {turn.time:g} s"
                )
        for agent in {turn.agent for turn in own} if isinstance(options["reward"], str) else ():
            total, expected = sum(turn.reward for turn in own if turn.agent == agent), paid[number][agent]
            if abs(total - expected) > CLOSE * (1.0 + abs(expected)):
                raise ConformanceError(
                    "rewards",
                    f"agent {agent} was paid {total:g} in episode {episode + 1}; what happened in it is worth "
                    f"{expected:g}",
                )


def _by_time(asked: Sequence[tuple[int, float]]) -> list[tuple[int, float]]:
    """Within one moment by agents."""
    return sorted(asked, key=lambda pair: (pair[1], pair[0]))


def _episode(colony: Colony, turns: Any) -> tuple[list[float], dict[int, float]]:
    """What each agent should be paid for the next episode of a colony, event by event, and when it ended for whom.

    Under -1 stands when it ended for all that are left.
    """
    agents = range(len(turns.scenario.agents))
    totals, done = [0.0 for _ in agents], dict[int, float]()
    there, arrived, before, filled = [False for _ in agents], 0, 0.0, set[int]()
    taking = 0
    while (event := colony.step()) is not None:
        if event.kind == "start":
            taking = int(colony.agents.takes_part.sum())
            there[event.agent] = True
            if event.time == 0.0:
                filled = set(colony.world.holes[colony.world.filled].tolist())
        now = set(colony.world.holes[colony.world.filled].tolist())
        new, filled = sorted(now - filled) if event.action == "push" else [], now
        stretch = Stretch(
            [event], before, event.time, colony.seconds_of_an_edge, taking, arrived, there[:], new, colony
        )
        for agent, value in enumerate(turns.reward(stretch)):
            totals[agent] += 0.0 if agent in done else value
        before = event.time
        if event.kind in ("goal", "lost", "spent"):
            done[event.agent] = event.time
            arrived += event.kind == "goal"
            there[event.agent] = event.kind == "spent"
        if event.kind == "episode":
            done[-1] = event.time
            break
    return totals, done


# -- copies ------------------------------------------------------------------------------------------------------------


def _check_copies(factory: Callable[[], Any], seed: int, played: Sequence[_Turn]) -> None:
    """Forks an environment on its way: neither goes another way for what the other one does."""
    env = factory()
    env.reset(seed=seed)
    for share in (0.1, 0.5, 0.9):
        at = int(share * len(played))
        while played[at].action is None and at:
            at -= 1
        env.reset(seed=seed)
        _same("copies", "the episode", [*_followed(env, played[:at])], played[:at])
        twin = env.fork()
        try:
            _same("copies", "a fork", [*_followed(twin, played[at:])], played[at:])
            _same("copies", "what was forked", [*_followed(env, played[at:])], played[at:])
        finally:
            twin.close()
    env.close()


def _followed(env: Any, played: Sequence[_Turn]) -> Iterator[_Turn]:
    """As many turns as were played, with the same actions as long as they are allowed."""
    for expected in played:
        if not env.agents:
            return

        def same(env: Any, mask: Sequence[int], action: int | None = expected.action) -> int:
            return action if action is not None and mask[action] else int(env.turns.observer.moves.pause)

        turn = _read(env, expected.episode, same)
        yield turn
        env.step(turn.action)
