"""What is asked for on the page of a run under way: to pause, to go on by an event, to change something, to begin anew.

The server's threads ask, the simulation's thread attends to it between two events.
"""

from __future__ import annotations

import threading
import time
from concurrent.futures import Future
from concurrent.futures import TimeoutError as Late
from typing import TYPE_CHECKING, Any

from colonysim.arguments import real
from colonysim.errors import Anew, ColonysimError
from colonysim.policies.parameters import shown
from colonysim.view.offers import offers

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from colonysim.simulation import Colony
    from colonysim.trace.reader import Run

__all__ = ["Controls"]

_PATIENCE = 20.0
"""Seconds that a request waits for the simulation, which attends to it between two events."""
_LONGEST = 2.0
"""Seconds that the run waits at most for the time of one event to pass: nobody sits through a stall of minutes."""
_LOOK = 0.02
"""Seconds from one look at what is asked for to the next, while the run waits."""
_FASTEST = 1e9
_WORDS = ("look", "pause", "go", "step", "pace", "change", "reset")


class Controls:
    """Controls a run from a page; `attend` is called by the run between two events.

    Args:
        pace: Simulated seconds that pass in a second; 0 for as many as may be.

    Attributes:
        number: How often the run has begun anew, for pages that show an earlier one.
    """

    def __init__(self, pace: float = 0.0) -> None:
        # The lock itself and no condition: a signal that ends the run could come within a condition's own methods, and
        # leave it locked for good.
        self._turn = threading.RLock()
        self._pace, self._paused, self._steps, self._anew = real("pace", pace, 0.0, _FASTEST), False, 0, False
        self._asked: list[tuple[Mapping[str, Any], Future[str]]] = []
        self._shown: dict[str, Any] = {}
        self._made: list[str] = []
        self._over, self.number = True, 0
        self._last = (0, 0.0)

    # -- the run's side ----------------------------------------------------------------------------------------------

    def begin(self, run: Run) -> None:
        """A run begins; what was asked of the one before is forgotten."""
        scenario, path = run.scenario, run.path
        heights = [box.height for box in scenario.boxes]
        with self._turn:
            self.number += 1
            self._shown = {
                "offers": offers(scenario, run.manifest["policy"]), "height": heights[0] if heights else 1.0,
                "kinds": [], "path": "" if path is None else str(path), "episode": 0, "time": 0.0,
            }  # fmt: skip
            self._made, self._over, self._anew, self._steps, self._last = [], False, False, 0, (0, 0.0)
            self._forget("the run has begun anew")

    def attend(self, colony: Colony, share: Callable[[], None]) -> None:
        """Does what was asked for, waits as long as the pace says, and while the run is paused.

        Args:
            colony: The colony, between two events.
            share: Has the pages see what there is so far.

        Raises:
            Anew: The run is to begin anew.
        """
        episode, now = colony.episode, colony.now
        before, self._last = self._last, (episode, now)
        passed = now - before[1] if before[0] == episode else now
        began = time.monotonic()
        with self._turn:
            self._note(colony)
        told = False
        while True:
            with self._turn:
                self._do(colony)
                if self._anew:
                    raise Anew
                rests = self._paused and not self._steps
                if self._paused and not rests:
                    self._steps -= 1
                    return
                left = min(passed / self._pace, _LONGEST) - (time.monotonic() - began) if self._pace else 0.0
            if not rests and left <= 0.0:
                return
            if rests and not told:
                told = True
                share()
            time.sleep(_LOOK if rests else min(left, _LOOK))

    def end(self) -> None:
        """The run is over: nothing can be asked of it but to begin anew."""
        with self._turn:
            self._over = True
            self._forget("the run is over")

    def _forget(self, why: str) -> None:
        """Answers those who have asked for a change that will not be made."""
        for _, answer in self._asked:
            answer.set_exception(ColonysimError(why))
        self._asked.clear()

    def wait_for_reset(self) -> None:
        """Waits, after the end of a run, until it is to begin anew."""
        while not self._anew:
            time.sleep(_LOOK)

    def _note(self, colony: Colony) -> None:
        """What pages may ask for at any moment."""
        self._shown.update(kinds=list(colony.changeable), episode=colony.episode, time=colony.now)
        held = colony.parameters
        for offer in self._shown["offers"]:
            for parameter in offer["parameters"]:
                parameter["value"] = held[offer["group"]].get(parameter["name"], parameter["default"])

    def _do(self, colony: Colony) -> None:
        """Makes the changes that were asked for."""
        while self._asked:
            item, answer = self._asked.pop(0)
            try:
                change = colony.change(item)
            except ColonysimError as error:
                answer.set_exception(error)
                if colony.over:
                    raise
                continue
            said = _in_words(colony, change.number)
            self._made.append(said)
            for offer in self._shown["offers"]:
                own = {} if change.parameters is None or offer["group"] != change.group else change.parameters
                for parameter in offer["parameters"]:
                    parameter["value"] = own.get(parameter["name"], parameter["value"])
            answer.set_result(said)

    # -- the pages' side ---------------------------------------------------------------------------------------------

    def ask(self, command: Mapping[str, Any]) -> dict[str, Any]:
        """Takes a command, and returns how it stands then, as plain data.

        Args:
            command: `{"do": ...}`, see the words in `_WORDS`; `pace` with `seconds`, `change` with an entry of
                `changes:`.

        Raises:
            ColonysimError: There is no such command, or what is asked for cannot be.
        """
        word, said = command.get("do"), ""
        if word not in _WORDS:
            raise ColonysimError(f"no command {str(word)[:50]!r}, expected one of {', '.join(_WORDS)}")
        with self._turn:
            if self._over and word not in ("look", "reset"):
                raise ColonysimError("the run is over")
            if word in ("pause", "step"):
                self._paused, self._steps = True, self._steps + (word == "step")
            elif word == "go":
                self._paused, self._steps = False, 0
            elif word == "pace":
                self._pace = real("pace", command.get("seconds"), 0.0, _FASTEST)
            elif word == "reset":
                self._anew, self._paused = True, False
            elif word == "change":
                item = command.get("change")
                if not isinstance(item, dict):
                    raise ColonysimError("change: expected a mapping, as an entry of `changes:`")
                answer: Future[str] = Future()
                self._asked.append((item, answer))
        if word == "change":
            try:
                said = answer.result(_PATIENCE)
            except Late:
                raise ColonysimError("the run has not come to its next event yet; it will be done then") from None
        return self.state() | {"said": said}

    def state(self) -> dict[str, Any]:
        """How it stands: what a page needs to show its controls."""
        with self._turn:
            return {
                **self._shown, "run": self.number, "over": self._over, "paused": self._paused, "pace": self._pace,
                "made": list(self._made),
            }  # fmt: skip


def _in_words(colony: Colony, number: int) -> str:
    """A change by hand as it stands in the scenario now."""
    item = colony.scenario.document["changes"][number]
    return ", ".join(f"{name}: {_short(value)}" for name, value in item.items())


def _short(value: Any) -> str:
    return shown(value)[:200]
