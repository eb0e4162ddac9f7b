"""Policies, fields and backends of others: what they answer is held against their protocol where it comes in, once.

Compiled code reads numbers without looking twice, so one out of range must not get as far. Our own parts are trusted.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable, Mapping, Sequence
from copy import deepcopy
from itertools import islice
from numbers import Real
from reprlib import Repr
from typing import TYPE_CHECKING, Any, Self, cast

from colonysim.backends.protocol import Done
from colonysim.errors import ColonysimError, PluginError
from colonysim.pheromones import BoxWorth, Distance, Exploration, HoleTrail
from colonysim.pheromones.field import Write
from colonysim.plugins import BUILT_IN, lacking
from colonysim.policies.policy import Choice
from colonysim.trace.schema import TABLES
from colonysim.world.intents import BoxPlace, Outcome, Push, Travel, Wait

if TYPE_CHECKING:
    import random

    from colonysim.backends.protocol import Backend, Finished, TraceRow
    from colonysim.pheromones.field import Field, Visit
    from colonysim.policies.policy import Policy
    from colonysim.policies.view import LocalView
    from colonysim.randomness import Streams
    from colonysim.trace.rows import Rows
    from colonysim.world.intents import Intent
    from colonysim.world.state import Place, World

__all__ = [
    "ForeignBackend", "ForeignField", "ForeignPolicy", "checked_backend", "checked_fields", "checked_policy",
    "overrides",
]  # fmt: skip

_OWN = {place for group in ("backends", "policies") for name, place in BUILT_IN[group].items() if name != "mock"}
_OWN |= {f"{kind.__module__}:{kind.__qualname__}" for kind in (BoxWorth, Distance, Exploration, HoleTrail)}
"""Whatever else is derived from them may answer as it likes; so may a script of the mock backend."""
MOST = 4_000_000
"""No answer has so many items."""
_LARGEST = 2.0**53
"""Numbers up to this are exact everywhere."""
_SHOWN = Repr()
_SHOWN.maxother = _SHOWN.maxstring = 200
_LONGEST_TEXT = 1000
"""Characters of a reason, and of a field's name: readers of a run take no longer ones."""
_OF_BACKENDS = ("poses", "controls")
"""The tables whose rows a backend may give; the others are the simulation's own."""


def overrides(thing: object) -> bool:
    """Whether an object has attributes of its own in place of its class's, such as another `decide`."""
    return any(hasattr(type(thing), name) for name in getattr(thing, "__dict__", ()))


def _own(thing: object) -> bool:
    kind = type(thing)
    return f"{kind.__module__}:{kind.__qualname__}" in _OWN and not overrides(thing)


def checked_fields(policy: Policy, world: World, rows: Rows) -> dict[str, Field]:
    """The fields of a policy by name; those of others, whoever carries them along, are looked at when they answer.

    Raises:
        PluginError: One is no field, or has a name that no trace could hold.
    """
    made = policy.fields(world)
    if not isinstance(made, Mapping):
        raise PluginError(f"policy {policy.name!r}: fields returns {_SHOWN.repr(made)}, expected fields by name")
    found: dict[str, Field] = {}
    for name, field in made.items():
        if not _is_text(name):
            raise PluginError(f"policy {policy.name!r}: a field's name is {_SHOWN.repr(name)}, expected some text")
        if missing := lacking("fields", field):
            raise PluginError(f"policy {policy.name!r}: field {name!r} {missing}")
        found[name] = field if _own(field) else ForeignField(field, world, rows)
    return found


def checked_policy(policy: Policy, world: World, rows: Rows) -> Policy:
    """The policy itself if it is one of ours, else what looks at its answers."""
    return policy if _own(policy) else ForeignPolicy(policy, world, rows)


def checked_backend(backend: Backend, world: World, rows: Rows) -> Backend:
    """The backend itself if it is one of ours, else what looks at its answers."""
    return backend if _own(backend) else cast("Backend", ForeignBackend(backend, world, rows))


def _told(error: BaseException) -> str:
    try:
        return f"{type(error).__name__}: {error}"
    except Exception:  # its words are another's code too
        return type(error).__name__


def _is_text(value: Any) -> bool:
    """Whether a value is a text that a trace can hold and readers take."""
    if not isinstance(value, str) or not 0 <= len(value) <= _LONGEST_TEXT:
        return False
    return value.isascii() or not any("\ud800" <= letter <= "\udfff" for letter in value)


def _fits(value: Any, kind: str) -> bool:
    """Whether a value can stand in a column of a kind."""
    if kind == "text":
        return _is_text(value)
    if kind == "bool":
        return isinstance(value, bool)
    if kind in ("ints", "floats"):
        return isinstance(value, Sequence) and all(_fits(each, kind[:-1]) for each in value)
    number = _real(value)
    return number is not None and abs(number) <= _LARGEST and (kind == "float" or isinstance(value, int))


def _whole(value: Any) -> int | None:
    """A whole number of whatever kind, as an int; None if it is none."""
    if type(value) is int:
        return value
    try:
        return None if isinstance(value, bool) else operator.index(value)
    except TypeError:
        return None


def _listed(given: Iterable[Any]) -> list[Any]:
    """What is given, as a list; what has no end is an error too."""
    found = list(islice(given, MOST))
    if len(found) == MOST:
        raise ValueError(f"it goes on after {MOST} items")
    return found


def _real(value: Any) -> float | None:
    """A finite number of whatever kind, as a float; None if it is none."""
    if not isinstance(value, Real) or isinstance(value, bool):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None


class _Foreign:
    """What all three have in common: they are called, and told what is wrong with the answer.

    Args:
        part: What another has written.
        what: "policy", "field" or "backend".
        world: The world; its scenario says what exists.
        rows: Knows the time.
    """

    def __init__(self, part: Any, what: str, world: World, rows: Rows) -> None:
        self._part, self._what, self._rows = part, what, rows
        self.name: str = part.name
        self._nodes, self._boxes, self._holes = len(world.topology), len(world.box_node), len(world.scenario.holes)
        self._world = world

    def __deepcopy__(self, memo: dict[int, object]) -> Self:
        """A copy in a copied world; what it knows the time by stays the same, and cannot be copied when compiled."""
        memo[id(self._rows)] = self._rows
        twin = memo[id(self)] = type(self).__new__(type(self))
        for name, value in vars(self).items():
            setattr(twin, name, deepcopy(value, memo))
        return twin

    def _fault(self, why: str, agent: int | None = None) -> PluginError:
        who = "" if agent is None else f", agent {agent}"
        return PluginError(f"{self._what} {self.name!r}{who} at {self._rows.now:g} s: {why}")

    def _call(self, method: str, *arguments: Any, agent: int | None = None) -> Any:
        try:
            return getattr(self._part, method)(*arguments)
        except (ColonysimError, MemoryError, KeyboardInterrupt):
            raise  # the first says already what is wrong, the others are no fault of the part's
        except BaseException as error:  # another's code may fail in any way, exit() included; ours still owes a message
            raise self._fault(f"{method} raises {_told(error)}", agent) from error

    def _listed(self, method: str, given: Any, agent: int | None = None) -> list[Any]:
        try:
            return _listed(given)
        except (ColonysimError, MemoryError):
            raise
        except Exception as error:
            why = f"{method} returns {_SHOWN.repr(given)}, expected a list ({type(error).__name__}: {error})"
            raise self._fault(why, agent) from error

    def _writes(self, method: str, by_box: bool, agent: int | None, given: Any) -> list[Write]:
        found = []
        for each in self._listed(method, given, agent):
            try:
                node, key, value = each
            except (TypeError, ValueError):
                raise self._fault(f"{method} returns {_SHOWN.repr(each)}, expected a Write", agent) from None
            place, hole, number = _whole(node), _whole(key), _real(value)
            if place is None or not 0 <= place < (self._boxes if by_box else self._nodes):
                what = "box" if by_box else "node"
                raise self._fault(f"{method} returns {_SHOWN.repr(each)}, but there is no such {what}", agent)
            if hole is None or not -1 <= hole < self._holes:
                raise self._fault(f"{method} returns {_SHOWN.repr(each)}, but its key is no hole and not -1", agent)
            if number is None:
                raise self._fault(f"{method} returns {_SHOWN.repr(each)}, expected a finite value", agent)
            found.append(Write(place, hole, number))
        return found


class ForeignField(_Foreign):
    """Looks at what a field of another answers."""

    def __init__(self, field: Field, world: World, rows: Rows) -> None:
        super().__init__(field, "field", world, rows)
        self.by_box = bool(field.by_box)

    def at(self, node: int, key: int = -1) -> float:
        """A finite number."""
        value = self._call("at", node, key)
        number = _real(value)
        if number is None:
            raise self._fault(f"at({node}, {key}) returns {_SHOWN.repr(value)}, expected a finite number")
        return number

    def keys(self, node: int) -> Sequence[int]:
        """Whole numbers; those that are no hole are nobody's."""
        found = [_whole(key) for key in self._listed("keys", self._call("keys", node))]
        if None in found:
            raise self._fault(f"keys({node}) returns {_SHOWN.repr(found)}, expected whole numbers")
        return [key for key in found if key is not None and -1 <= key < self._holes]

    def deposit(self, visit: Visit) -> Iterable[Write]:
        """Finite values at what exists."""
        return self._writes("deposit", self.by_box, visit.agent, self._call("deposit", visit, agent=visit.agent))

    def end_episode(self) -> None:
        """It may raise."""
        self._call("end_episode")

    def frame(self) -> Iterable[Write]:
        """Finite values at what exists."""
        return self._writes("frame", self.by_box, None, self._call("frame"))

    def load(self, frame: Iterable[Write]) -> None:
        """It may raise."""
        self._call("load", frame)


class ForeignPolicy(_Foreign):
    """Looks at what a policy of another decides."""

    def __init__(self, policy: Policy, world: World, rows: Rows) -> None:
        super().__init__(policy, "policy", world, rows)

    def fields(self, world: World) -> Mapping[str, Field]:
        """It may raise; `checked_fields` looks at what it gives."""
        return cast("Mapping[str, Field]", self._call("fields", world))

    def begin(self, agent: int, memory: Any) -> Any:
        """It may raise."""
        return self._call("begin", agent, memory, agent=agent)

    def decide(self, view: LocalView, memory: Any, random: random.Random) -> Choice:
        """An intent that speaks of what exists, and a choice that fits the trace."""
        agent = view.agent
        choice = self._call("decide", view, memory, random, agent=agent)
        if not isinstance(choice, Choice):
            raise self._fault(f"decide returns {_SHOWN.repr(choice)}, expected a Choice", agent)
        intent, why = self._intent(agent, choice.intent)
        if not why:
            why = self._options(choice)
        if why or intent is None:
            raise self._fault(f"it wants {_SHOWN.repr(choice.intent)}: {why}", agent)
        return choice if intent is choice.intent else choice._replace(intent=intent)

    def _intent(self, agent: int, intent: Any) -> tuple[Intent | None, str]:
        """The intent with plain numbers, and what is wrong with it."""
        if isinstance(intent, Wait):
            return self._wait(intent)
        if not isinstance(intent, Travel | Push):
            return None, "expected a Travel, a Push or a Wait"
        node, at = _whole(intent.node), self._world.agent_node[agent]
        if node is None or not 0 <= node < self._nodes:
            return None, "there is no such node"
        if node not in self._world.topology.neighbours[at]:
            return None, f"no edge leads there from node {at}"
        if isinstance(intent, Travel):
            return (intent if type(intent.node) is int else Travel(node)), ""
        box, hole = _whole(intent.box), _whole(intent.hole)
        if box is None or not 0 <= box < self._boxes:
            return None, "there is no such box"
        if hole is None or not -1 <= hole < self._holes:
            return None, "there is no such hole"
        plain = type(intent.node) is type(intent.box) is type(intent.hole) is int
        return (intent if plain else Push(box, node, hole)), ""

    def _wait(self, wait: Wait) -> tuple[Wait | None, str]:
        try:
            nodes = tuple([_whole(node) for node in _listed(wait.nodes)])
        except Exception:  # whatever goes wrong in going through them
            return None, "expected nodes to wait for"
        if not all(node is not None and 0 <= node < self._nodes for node in nodes):
            return None, "there is no such node to wait for"
        seconds, clear = None if wait.seconds is None else _real(wait.seconds), _whole(wait.clear)
        if wait.seconds is not None and (seconds is None or seconds <= 0.0):
            return None, "expected a time above 0 that has an end, or None to wait for a change"
        if clear is None or not -1 <= clear < self._nodes:
            return None, "there is no such node to be cleared"
        return Wait(nodes, seconds, clear), ""  # type: ignore[arg-type]

    def _options(self, choice: Choice) -> str:
        try:
            targets, boxes = _listed(choice.targets), _listed(choice.boxes)
            chances = _listed(choice.probabilities)
        except Exception:
            return "expected targets, boxes and probabilities of the choice"
        if not targets and not boxes and not chances:
            return ""
        if not len(targets) == len(boxes) == len(chances):
            return f"its choice has {len(targets)} targets, {len(boxes)} boxes and {len(chances)} probabilities"
        for target, box, chance in zip(targets, boxes, chances, strict=True):
            node, number = _whole(target), _whole(box)
            if node is None or not 0 <= node < self._nodes:
                return f"one of its targets is {_SHOWN.repr(target)}, expected a node"
            if number is None or not -1 <= number < self._boxes:
                return f"one of the boxes of its choice is {_SHOWN.repr(box)}, expected a box or -1"
            if _real(chance) is None:
                return f"one of its probabilities is {_SHOWN.repr(chance)}, expected a number"
        return ""


class ForeignBackend(_Foreign):
    """Looks at what a backend of another answers."""

    def __init__(self, backend: Backend, world: World, rows: Rows) -> None:
        super().__init__(backend, "backend", world, rows)
        self.tick: float | None = None
        self.edge_seconds = 1.0
        self._under_way: dict[int, Intent] = {}
        self.feasible_way = self._along if getattr(backend, "feasible_way", None) is not None else None

    def reset(self, world: World, streams: Streams) -> None:
        """The times that it is known by are above 0 then."""
        self._under_way.clear()
        self._call("reset", world, streams)
        for name in ("tick", "edge_seconds"):
            given = getattr(self._part, name, None)
            seconds = _real(given)
            if (seconds is None or seconds <= 0.0) and not (name == "tick" and given is None):
                raise self._fault(f"{name} is {_SHOWN.repr(given)}, expected seconds above 0")
            setattr(self, name, seconds)

    def feasible(self, agent: int, box: int, targets: Sequence[int]) -> Sequence[float]:
        """A chance for each target."""
        return self._chances("feasible", agent, self._call("feasible", agent, box, targets, agent=agent), len(targets))

    def _along(self, agent: int, box: int, way: Sequence[int]) -> Sequence[float]:
        given = self._call("feasible_way", agent, box, way, agent=agent)
        return self._chances("feasible_way", agent, given, max(0, len(way) - 1))

    def _chances(self, method: str, agent: int, given: Any, count: int) -> list[float]:
        chances = [_real(chance) for chance in self._listed(method, given, agent)]
        if len(chances) != count:
            raise self._fault(f"{method} returns {len(chances)} chances, expected {count}", agent)
        found = [chance for chance in chances if chance is not None and 0.0 <= chance <= 1.0]
        if len(found) != count:
            raise self._fault(f"{method} returns {_SHOWN.repr(given)}, expected chances from 0 to 1", agent)
        return found

    def footprint(self, agent: int, intent: Intent) -> frozenset[Place]:
        """Nodes and edges that exist."""
        given = self._call("footprint", agent, intent, agent=agent)
        found: list[Place] = []
        for place in self._listed("footprint", given, agent):
            ends = tuple(_whole(end) for end in (place if isinstance(place, tuple) else (place,)))
            if len(ends) > 2 or not ends or not all(end is not None and 0 <= end < self._nodes for end in ends):
                why = f"footprint of {_SHOWN.repr(intent)} holds {_SHOWN.repr(place)}, expected a node or an edge"
                raise self._fault(why, agent)
            found.append(ends if isinstance(place, tuple) else ends[0])  # type: ignore[arg-type]
        return frozenset(found)

    def start(self, agent: int, intent: Intent, now: float) -> Done | None:
        """An outcome with its time, or none yet if there is a clock."""
        done = self._call("start", agent, intent, now, agent=agent)
        if done is None:
            if self.tick is None:
                why = f"start returns None for {_SHOWN.repr(intent)}, expected a Done, as it has no tick"
                raise self._fault(why, agent)
            self._under_way[agent] = intent
            return None
        try:
            given, outcome = done.seconds, done.outcome
        except AttributeError:
            raise self._fault(f"start returns {_SHOWN.repr(done)}, expected a Done or None", agent) from None
        seconds = _real(given)
        if seconds is None or seconds < 0.0 or not math.isfinite(now + seconds):
            why = f"{_SHOWN.repr(intent)} takes {_SHOWN.repr(given)} seconds, expected a number that is not negative"
            raise self._fault(why, agent)
        checked = self._outcome(agent, intent, outcome)
        return Done(seconds, checked)

    def advance(self, now: float) -> Sequence[Finished]:
        """Outcomes of what is under way."""
        finished = self._listed("advance", self._call("advance", now))
        found: list[Any] = []
        for each in finished:
            try:
                number, outcome = each
            except (TypeError, ValueError):
                raise self._fault(f"advance returns {_SHOWN.repr(each)}, expected a Finished") from None
            agent = _whole(number)
            if agent not in self._under_way:
                raise self._fault(f"advance returns {_SHOWN.repr(each)}, but no such agent has an action under way")
            assert agent is not None
            found.append((agent, self._outcome(agent, self._under_way.pop(agent), outcome)))
        return found

    def _outcome(self, agent: int, intent: Intent, outcome: Any) -> Outcome:
        """The outcome with plain numbers."""
        why = ""
        if not isinstance(outcome, Outcome):
            why = "expected an Outcome"
        elif outcome.status not in ("arrived", "blocked", "failed"):
            why = "there is no such status"
        elif not _is_text(outcome.reason) or not isinstance(outcome.lost, bool):
            why = f"expected a reason in at most {_LONGEST_TEXT} characters, and for lost True or False"
        else:
            try:
                node, kept = _whole(outcome.node), tuple([_whole(each) for each in _listed(outcome.keeps)])
                places = tuple([BoxPlace(*place) for place in _listed(outcome.boxes)])
            except Exception:  # whatever goes wrong in going through them
                why = "expected nodes that it keeps, and a BoxPlace for each box"
            else:
                if not all(each is not None and 0 <= each < self._nodes for each in (node, *kept)):
                    why = "there is no such node"
                boxes = [BoxPlace(_whole(b), _whole(n), bool(stray)) for b, n, stray in places]  # type: ignore[arg-type]
                for box, place, _ in boxes:
                    if box is None or not 0 <= box < self._boxes:
                        why = "there is no such box"
                    elif place is None or not 0 <= place < self._nodes:
                        why = "there is no such node for the box"
        if why:
            raise self._fault(f"{_SHOWN.repr(intent)} came to {_SHOWN.repr(outcome)}: {why}", agent)
        if type(outcome.node) is int and not kept and not boxes:
            return outcome  # type: ignore[no-any-return]
        return Outcome(outcome.status, node, tuple(boxes), outcome.reason, outcome.lost, kept)  # type: ignore[arg-type]

    def cancel(self, agent: int) -> None:
        """No outcome may come of it."""
        self._under_way.pop(agent, None)
        self._call("cancel", agent, agent=agent)

    def leave(self, agent: int) -> None:
        """No outcome may come of it."""
        self._under_way.pop(agent, None)
        self._call("leave", agent, agent=agent)

    def rows(self) -> Iterable[TraceRow]:
        """Rows that fit their table."""
        given = self._listed("rows", self._call("rows"))
        for each in given:
            try:
                table, row = each
                kinds = [*TABLES[table].values()][1:]  # the simulation puts the episode in front
                fits = table in _OF_BACKENDS and len(row) == len(kinds)
                fits = fits and all(_fits(value, kind) for value, kind in zip(row, kinds, strict=True))
            except (TypeError, ValueError, LookupError):
                fits = False
            if not fits:
                raise self._fault(f"rows returns {_SHOWN.repr(each)}, expected rows of {' and '.join(_OF_BACKENDS)}")
        return given

    def close(self) -> None:
        """It may raise."""
        self._call("close")
