"""The policy `learned`: a network decides for each agent, from the observations of `colonysim.rl`."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from colonysim.errors import ColonysimError
from colonysim.plugins import make_policy
from colonysim.policies.policy import Choice
from colonysim.rl.models import CHOICES, load_policy, shipped_policies
from colonysim.rl.spaces import Observer
from colonysim.suggest import nearest

if TYPE_CHECKING:
    import random
    from collections.abc import Mapping

    from colonysim.pheromones.field import Field
    from colonysim.policies.view import LocalView
    from colonysim.scenario.scenario import Scenario
    from colonysim.world.state import World

__all__ = ["Learned"]

OWN = ("model", "choice")
"""Its own parameters; all others are those of the policy whose marks the agents leave."""


class Learned:
    """A network decides, which was learned in an environment of `colonysim.rl`; see `colonysim.rl.save_policy`.

    Args:
        scenario: Its `policy:` section says `model`, the path of the network's card or the name of one that comes with
            the package, and may say `choice`: "greedy" or "sampled" (from the agent's own random stream).

    Raises:
        ScenarioError: A parameter does not fit, or the network was made for other places.
    """

    name = "learned"

    def __init__(self, scenario: Scenario) -> None:
        parameters = scenario.parameters
        source, choice = parameters.get("model"), parameters.get("choice")
        if not isinstance(source, str):
            near = nearest("model", parameters) if parameters else "expected policy.model=FILE"
            known = ", or ".join(["the path of a network's card", *shipped_policies()])
            hint = near if near.startswith("did") else f"expected {known}"
            raise scenario.fault("policy.model", f"the policy {self.name!r} needs a network; {hint}")
        if choice is not None and choice not in CHOICES:
            raise scenario.fault("policy.choice", f"is {choice!r:.80}; {nearest(str(choice), CHOICES)}")
        try:
            model = self.model = load_policy(source)
        except ColonysimError as error:
            raise scenario.fault("policy.model", str(error)) from error
        self._sampled = (model.choice if choice is None else choice) == "sampled"
        others = {name: value for name, value in parameters.items() if name not in OWN}
        self._marks = make_policy(model.marks, replace(scenario, policy=model.marks, parameters=others))
        told = model.observation
        by_box = dict.fromkeys(told["fields"], False)
        try:
            self._observer = Observer(
                scenario, by_box, parts=told["parts"], flat=True, boxes=told["boxes"], holes=told["holes"],
                by_action=told["hole"] == "action", neighbours=told["neighbours"],
            )  # fmt: skip
        except ColonysimError as error:
            raise scenario.fault("policy.model", f"{model.file}: {error}") from None
        self._scenario = scenario

    def fields(self, world: World) -> Mapping[str, Field]:
        """Those of the policy whose marks the agents leave.

        Raises:
            ScenarioError: They are others than those that the network was told of.
        """
        found: Mapping[str, Field] = self._marks.fields(world)
        there, told = [name for name, field in found.items() if not field.by_box], self.model.observation["fields"]
        if "pheromones" in self.model.observation["parts"] and there != told:
            why = f"was told of the fields {', '.join(told) or 'none'}, and here are {', '.join(there) or 'none'}"
            raise self._scenario.fault("policy.model", f"{self.model.file}: {why}")
        return found

    def begin(self, agent: int, memory: Any) -> None:
        """Nothing to remember."""

    def decide(self, view: LocalView, memory: None, random: random.Random) -> Choice:
        """The action of the network's choice."""
        observer = self._observer
        sight = observer.sight(view)
        action = self.model.act(observer.numbers(sight), observer.mask(sight), random if self._sampled else None)
        intent = sight.intent(action)
        assert intent is not None  # of all that are allowed
        return Choice(intent, memory)
