"""Writes down what a colony is between two events, and makes another one the same."""

from __future__ import annotations

from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any, TypeVar

from colonysim import __version__
from colonysim.errors import ColonysimError, ScenarioError, UnsavableError
from colonysim.policies.decision import decision_of, decision_state
from colonysim.provenance import files_of, other_file
from colonysim.randomness import Streams
from colonysim.simulation.episode_state import episode_state, restore_episode, resume_streams
from colonysim.simulation.groups import decider_of
from colonysim.simulation.order import CHANGE_STEP, CHANGES
from colonysim.simulation.origins import backend_of, policy_of, scenario_of
from colonysim.simulation.saving import Saved
from colonysim.simulation.settings import changed
from colonysim.states import Stored, copied
from colonysim.trace.schema import Measurement

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
    from pathlib import Path

    from colonysim.backends.protocol import Backend
    from colonysim.policies.decision import Decision
    from colonysim.policies.policy import Policy
    from colonysim.scenario.scenario import Scenario
    from colonysim.simulation.colony import Colony
    from colonysim.states import State
    from colonysim.trace.schema import Sink

__all__ = [
    "Course", "adopt", "check_plain", "check_savable", "closed_on_error", "diverge", "loaded", "refuse_other_files",
    "replays", "restore", "saved_of", "state_of",
]  # fmt: skip

C = TypeVar("C", bound="Colony")

_MOMENT = ("world", "episode")
"""The parts by which it is found out whether going through an episode again came to the same moment."""
_CLOCKED = ("wall",)
"""What differs between two states of the same moment."""


class Course:
    """How a colony on a backend that cannot say its state came to where it is: by what it goes through it again.

    Args:
        scenario: The colony's.

    Attributes:
        scenario: The scenario as it was then.
        begun: The colony's state before the episode under way began; None where it is not needed.
        changes: What was changed since, after how many of SimPy's steps of the episode and how many answers: by a fork
            the seed of new random streams or None, and fields of the scenario; by hand the change.
        answers: The decisions from outside since, each with its agent's memory.
    """

    def __init__(self, scenario: Scenario) -> None:
        self.scenario, self.changes = scenario, []  # type: tuple[Scenario, list[dict[str, Any]]]
        self.answers: list[dict[str, Any]] = []
        self.begun: State | None = None

    def begin(self, colony: Colony) -> None:
        """The next episode of a colony is about to begin."""
        self.scenario, self.changes, self.answers, self.begun = colony.scenario, [], [], None
        if replays(colony._body):
            with suppress(ColonysimError):  # a part cannot say its state, which whoever wants to save it is told
                self.begun = state_of(colony)

    def note_change(
        self, colony: Colony, *, seed: int | None = None, settings: Mapping[str, Any] | None = None,
        by_hand: Mapping[str, Any] | None = None,
    ) -> None:  # fmt: skip
        """Something has been changed in the episode under way, which going through it again will need."""
        if colony._running:
            steps, answers = colony._episode.stepped, len(self.answers)
            self.changes.append(
                {"steps": steps, "answers": answers, "seed": seed, "settings": settings or {}, "by_hand": by_hand}
            )

    def note(self, colony: Colony, agent: int, decision: Decision) -> None:
        """A decision has come from outside, which going through the episode again will need."""
        if self.begun is not None:
            memory = colony._policy.state(agent, decision.memory)
            self.answers.append({"decision": decision_state(decision), "memory": copied(memory, "a memory")})


def check_savable(colony: Colony) -> None:
    """Checks that every part of a colony can be saved.

    Raises:
        UnsavableError: One cannot.
    """
    for field in colony._fields.values():
        if hasattr(field, "check_savable"):
            field.check_savable()
    body = colony._body
    if not (says_state(body) or getattr(body, "replayable", False)):
        raise UnsavableError(
            f"backend {body.name!r} can neither say its state (methods 'state' and 'restore' of its own) nor go "
            "through an episode again exactly ('replayable'), without which a colony cannot be saved"
        )


def check_plain(colony: Colony) -> None:
    """Checks that fields and memories can be handed over to others.

    Raises:
        ColonysimError: One cannot say its state.
    """
    for field in colony._fields.values():
        field.state()
    _memories(colony)


def says_state(body: Backend) -> bool:
    """Whether a backend has the methods by which it takes part in saving."""
    return bool(getattr(body, "savable", callable(getattr(body, "state", None))))


def replays(body: Backend) -> bool:
    """Whether a colony on this backend is brought to a moment by going through the episode again."""
    return not says_state(body) and bool(getattr(body, "replayable", False))


def state_of(colony: Colony) -> State:
    """All that a colony is between two events, as plain data.

    Raises:
        ColonysimError: A part of others cannot say it.
    """
    check_savable(colony)
    streams = colony._streams
    state: State = {
        "seed": streams.seed, "path": streams.path, "number": colony._number, "running": colony._running,
        "aged": colony._aged, "tuning": copied(colony._tuning, "tuning"), "world": colony._world.state(),
        "fields": {name: field.state() for name, field in colony._fields.items()},
        "memories": _memories(colony),
        "rows": colony._rows.state(), "measures": colony._measures.state(),
        "measured": [list(row) for row in colony._measured],
        "episode": episode_state(colony._episode) if colony._number else None, "backend": None, "course": None,
    }  # fmt: skip
    if colony._running:
        if replays(colony._body):
            begun, changes, answers = colony._course.begun, colony._course.changes, colony._course.answers
            if begun is None:  # a part could not say it then, and most likely cannot now
                raise ColonysimError("this colony cannot be saved before its next episode: a part had no plain state")
            state["course"] = {
                "begun": copied(begun, "begun"), "changes": copied(changes, "changes"),
                "answers": copied(answers, "answers"),
            }  # fmt: skip
        else:
            state["backend"] = colony._body.state()  # type: ignore[attr-defined]
    return state


def _memories(colony: Colony) -> list[Any] | None:
    """What each agent remembers, as plain data; None before the first episode."""
    if not colony._number:
        return None
    return [colony._policy.state(agent, memory) for agent, memory in enumerate(colony._memories)]


def restore(colony: Colony, state: State) -> None:
    """Makes a colony that has not begun the same as that of a state.

    Raises:
        ColonysimError: It is no state of such a colony.
    """
    told = Stored(state, "colony")
    course = told.take("course")
    if course is not None:
        _go_through(colony, told, Stored(course, "course"))
    else:
        _take_over(colony, told)
    colony._rows.restore(told.take("rows"), colony._number, colony._world.now)
    colony._measures.restore(told.take("measures"))
    rows = [_measurement(row) for row in told.listed("measured")]
    colony._measured[:] = rows


def _measurement(row: Any) -> Measurement:
    each = Stored(dict(zip(Measurement._fields, row if isinstance(row, list) else (), strict=False)), "a measurement")
    value = each.take("value")
    if type(value) is not float:
        raise each.fault("value", value, "a number")
    return Measurement(each.whole("episode", 1), each.real("time", 0.0), each.text("name"), value)


def _take_over(colony: Colony, told: Stored) -> None:
    """Puts every part into its state."""
    path = told.text("path")
    _take_tuning(colony, told)
    colony._streams = Streams(told.whole("seed", 0, 10**18), path)
    colony._number, colony._aged = told.whole("number", 0, colony._count), told.flag("aged")
    running, world, body = told.flag("running"), colony._world, colony._body
    fields, given = colony._fields, told.part("fields")
    if missing := fields.keys() ^ told.take("fields").keys():  # a mapping, or it were no part
        names = ", ".join(sorted(missing))
        raise ColonysimError(f"the saved colony has other pheromone fields than this policy: {names}")
    for name, field in fields.items():
        field.restore(given.take(name))
    if colony._number:
        memories = told.listed("memories", len(colony._memories))
        colony._memories[:] = [colony._policy.restore(agent, memory) for agent, memory in enumerate(memories)]
    own = colony._streams.within(f"episode/{colony._number}")
    if running:
        body.reset(world, own)  # with everything where it starts: what has changed since is in the states
    world.restore(told.take("world"))
    if running:
        body.restore(told.take("backend"))  # type: ignore[attr-defined]
    if colony._number:
        restore_episode(
            colony._episode,
            told.take("episode"),
            colony._number,
            colony._memories,
            own,
            synchronous=colony.mode == "synchronous",
            under_way=running,
        )
    colony._running = running


def _take_tuning(colony: Colony, told: Stored) -> None:
    """Has the agents decide by the parameters that hold in a state."""
    tuning, groups = told.take("tuning"), {"", *(group.name for group in colony.scenario.groups)}
    if not (isinstance(tuning, dict) and tuning.keys() <= groups and all(type(own) is dict for own in tuning.values())):
        raise told.fault("tuning", tuning, "parameters by groups that there are")
    if tuning != colony._tuning:
        colony._tuning = tuning
        colony._take_policies(colony._make_policies())
        colony._set_up()


def _go_through(colony: Colony, told: Stored, course: Stored) -> None:
    """Goes through the episode under way again, without rows and observers, to the same moment."""
    begun = course.take("begun")
    if not isinstance(begun, dict) or begun.get("running") is not False:
        raise course.fault("begun", type(begun).__name__, "the state before an episode")
    _take_over(colony, Stored(begun, "colony before the episode"))
    steps, answers = told.part("episode").whole("stepped"), course.listed("answers")
    colony._rows.hush(True)
    try:
        if not colony._begin_next():
            raise course.fault("begun", "the end of the run", "an episode to come")
        for change in course.listed("changes"):
            each = Stored(change, "a change")
            _step_to(colony, each.whole("steps", 0, steps), answers[: each.whole("answers", 0, len(answers))])
            seed, by_hand = each.take("seed"), each.take("by_hand")
            if by_hand is not None:
                colony.change(by_hand)
            else:
                diverge(colony, None if seed is None else each.whole("seed"), each.take("settings"))
        _step_to(colony, steps, answers)
    finally:
        colony._rows.hush(False)
    colony._world.now = max(colony._world.now, told.part("world").real("now", 0.0))
    episode = colony._episode
    if episode.outside:
        resume_streams(episode, told.part("episode"))  # whoever decided outside drew from them
    found = {"world": colony._world.state(), "episode": episode_state(episode)}
    for name in _MOMENT:
        before = told.take(name)
        for key, value in found[name].items():
            if key not in _CLOCKED and before.get(key) != value:
                raise ColonysimError(
                    f"backend {colony._body.name!r}: going through the episode again came to another moment ({name}, "
                    f"{key}): it was saved with another version of the engine, or on another kind of processor"
                )


def _step_to(colony: Colony, steps: int, answers: Sequence[Any]) -> None:
    """Goes through the episode under way again to a number of SimPy's steps and of answers from outside."""
    given = colony._course.answers
    while True:
        episode = colony._episode
        while episode.asked >= 0 and len(given) < len(answers):
            told = Stored(answers[len(given)], "an answer")
            decision = decision_of(told.take("decision"), colony._world, "an answer")
            if decision is None:
                raise told.fault("decision", None, "a decision")
            decision.memory = colony._policy.restore(episode.asked, told.take("memory"))
            colony._course.note(colony, episode.asked, decision)
            episode.answer(decision)
        if episode.stepped >= steps:
            return
        if not episode.go_through(steps) and episode.asked < 0:
            raise ColonysimError("going through the episode again came to its end before that moment")
        if episode.timeline.tunings:
            colony._tune()
            continue
        if episode.asked >= 0 and len(given) == len(answers) and episode.stepped < steps:
            raise ColonysimError("going through the episode again came to a decision that nobody has taken")


def diverge(colony: Colony, seed: int | None, settings: Mapping[str, Any] | Sequence[str] | None) -> None:
    """Gives a colony other random streams from now on, or changes fields of its scenario.

    Args:
        colony: The colony, between two events.
        seed: What the streams are derived from; None for those that it has.
        settings: Fields of the scenario by dotted path, as for `load_scenario`; None for none.

    Raises:
        ColonysimError: A field cannot change under way.
    """
    now: dict[str, Any] = {}
    if settings:
        asked = colony._asked
        if not (asked is None or isinstance(asked, str) or callable(asked)):
            raise ColonysimError(
                "this policy was given as an object, whose parameters no field of the scenario can set"
            )
        scenario = changed(colony.scenario, settings)
        now = scenario.settings
        _refuse_past(colony, scenario, now)
        for path in now:  # what is set now holds from now on, whatever a timeline has set before
            section, _, name = path.partition(".")
            if section == "policy":
                colony._tuning.get("", {}).pop(name, None)
        adopt(colony, scenario, tuned=True)
    if seed is not None:
        colony._streams = Streams(seed, "fork/")
        if colony._running:
            own = colony._streams.within(f"episode/{colony._number}")
            colony._episode.reseed(own)
            colony._body.reseed(own)  # type: ignore[attr-defined]
    if seed is not None or settings:
        colony._course.note_change(colony, seed=seed, settings=now)


def _refuse_past(colony: Colony, scenario: Scenario, settings: Mapping[str, Any]) -> None:
    """Refuses settings that speak of what has happened already."""
    fixed = {name for n in range(len(colony._agents)) for name in getattr(decider_of(colony._policy, n), "fixed", ())}
    for path in settings:
        if path.removeprefix("policy.") in fixed:
            raise ScenarioError(f"--set {path}: cannot change under way, as marks are kept by it")
    if colony._running and scenario.time_limit is not None and scenario.time_limit <= colony.now:
        limit = f"--set time_limit={scenario.time_limit:g}"
        raise ScenarioError(f"{limit}: the episode under way is at {colony.now:g} s, expected more than that")


def adopt(colony: Colony, scenario: Scenario, due: float | None = None, *, tuned: bool = False) -> None:
    """Goes on with another scenario of the same place: policy and fields are made anew and take over the states.

    Args:
        colony: The colony, between two events.
        scenario: The scenario. Its timeline may have one change more at its end, and with that one box more.
        due: When that change comes in the episode under way, simulated seconds; None if it does not come in it.
        tuned: Whether policies have other parameters from now on, by which marks may fade otherwise.

    Raises:
        ColonysimError: The policy would have other fields.
    """
    world, number, before, policy = colony._world, colony._number, colony._episode, colony._policy
    for field in colony._fields.values() if tuned else ():
        field.refresh()
    fields, state = (
        {name: field.state() for name, field in colony._fields.items()},
        episode_state(before) if number else None,
    )
    memories = _memories(colony)
    if state is not None and len(scenario.changes) > len(colony.scenario.changes):
        timeline, comes = state["timeline"], due is not None
        timeline["due"].append(due if comes else 0.0)
        timeline["orders"].append(CHANGES + CHANGE_STEP * scenario.changes[-1].number if comes else -1.0)
    colony.scenario = scenario
    world.adopt(scenario)
    colony._take_policies(colony._make_policies())
    colony._files = files_of(scenario.parameters, colony._origin.options, scenario.parts_of_groups)
    if other := fields.keys() ^ colony._fields.keys():
        raise ColonysimError(f"other pheromone fields cannot come or go under way: {', '.join(sorted(other))}")
    if "episodes" in scenario.overrides:
        colony._count = max(number, scenario.episodes)
    for name, field in colony._fields.items():
        field.restore(fields[name])
    if memories is not None:
        for agent, memory in enumerate(memories):
            now, then = decider_of(colony._policy, agent), decider_of(policy, agent)
            colony._memories[agent] = now.take_over(now.restore(agent, memory), then)
    colony._set_up()
    colony._episode.slice = before.slice
    own = colony._streams.within(f"episode/{number}")
    if colony._running and says_state(colony._body):  # which may have read the scenario when it was reset
        body: Any = colony._body
        moved = body.state()
        body.reset(world, own)
        body.restore(moved)
    if state is not None:
        restore_episode(
            colony._episode, state, number, colony._memories, own, synchronous=colony.mode == "synchronous",
            under_way=colony._running,
        )  # fmt: skip
    before.close()


def saved_of(colony: Colony, extra: Mapping[str, Any] | None = None) -> Saved:
    """All that a colony is now.

    Args:
        colony: The colony.
        extra: What else to write down.

    Raises:
        ColonysimError: It is closed, or a part of others cannot say its state.
    """
    if colony._closed:
        raise ColonysimError("a colony that is closed, or has come to its end, has no future to save")
    if colony._measuring:
        raise ColonysimError("a colony cannot be saved in the middle of a measurement")
    state = state_of(colony)
    scenario = colony._course.scenario if state["course"] else colony.scenario
    return Saved(
        scenario.document, scenario.digest, colony._origin, colony.mode, colony._count, state, __version__, extra or {},
        colony._files,
    )  # fmt: skip


def refuse_other_files(saved: Saved, scenario: Scenario, options: Mapping[str, Any] | None) -> None:
    """Refuses to go on with a file of a model that is another one than when the colony was made.

    Raises:
        ColonysimError: One is.
    """
    if other := other_file(saved.files, files_of(scenario.parameters, options, scenario.parts_of_groups)):
        raise ColonysimError(f"saved with {other}")


@contextmanager
def closed_on_error(colony: Colony) -> Iterator[None]:
    """Closes a colony that does not come to be what it should."""
    try:
        yield
    except BaseException:
        colony._fail()
        raise


def loaded(
    kind: type[C],
    path: Path,
    saved: Saved,
    *,
    scenario: Scenario | str | Path | None = None,
    backend: str | Backend | None = None,
    backend_options: Mapping[str, Any] | None = None,
    policy: str | Policy | Callable[[Scenario], Policy] | None = None,
    sink: Sink | None = None,
    decisions: bool = True,
    kinds: Collection[str] | None = None,
) -> C:
    """A colony that goes on where a saved one has come to; see `Colony.load`.

    Args:
        kind: Its class.
        path: Where it was read, for messages.
        saved: What was read there.
        scenario: See `Colony.load`, as all others.
        backend: The same.
        backend_options: The same.
        policy: The same.
        sink: The same.
        decisions: The same.
        kinds: The same.
    """
    place = scenario_of(saved, path, scenario)
    try:
        mover, options = backend_of(saved, backend, backend_options)
        refuse_other_files(saved, place, options)
        colony = kind(
            place, backend=mover, backend_options=options, policy=policy_of(saved, policy), mode=saved.mode, sink=sink,
            episodes=saved.episodes, decisions=decisions, kinds=kinds,
        )  # fmt: skip
        with closed_on_error(colony):
            restore(colony, saved.state)
    except ScenarioError:
        raise
    except ColonysimError as error:
        raise type(error)(f"{path}: {error}") from None
    return colony
