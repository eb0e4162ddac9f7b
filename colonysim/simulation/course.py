"""How a colony on a backend that cannot say its state is brought to a moment: its episode is gone through again."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, Any

from colonysim.errors import ColonysimError
from colonysim.policies.decision import decision_of, decision_state
from colonysim.simulation.adopting import diverge
from colonysim.simulation.colony_state import replays, state_of, take_over
from colonysim.simulation.episode_state import episode_state, resume_streams
from colonysim.states import Stored, copied

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from colonysim.policies.decision import Decision
    from colonysim.scenario.scenario import Scenario
    from colonysim.simulation.colony import Colony
    from colonysim.states import State

__all__ = ["Course", "go_through"]

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


def go_through(colony: Colony, told: Stored, course: Stored) -> None:
    """Goes through the episode under way again, without rows and observers, to the same moment."""
    begun = course.take("begun")
    if not isinstance(begun, dict) or begun.get("running") is not False:
        raise course.fault("begun", type(begun).__name__, "the state before an episode")
    take_over(colony, Stored(begun, "colony before the episode"))
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
