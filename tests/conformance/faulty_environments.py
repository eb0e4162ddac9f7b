"""Environments that each break one promise; `check_env` must name it."""

from __future__ import annotations

from colonysim.randomness import Streams
from colonysim.rl import ColonyAEC, Turns


class StaleMask(ColonyAEC):
    """Shows each agent the mask of its first question."""

    def reset(self, seed=None, options=None):
        self.masks = {}
        super().reset(seed, options)

    def observe(self, agent):
        found = super().observe(agent)
        if not (self.terminations[agent] or self.truncations[agent]):
            found["action_mask"] = self.masks.setdefault(agent, found["action_mask"])
        return found


class Leaks(ColonyAEC):
    """Tells each agent of the next one what only that can know."""

    def observe(self, agent):
        found, names = super().observe(agent), self.possible_agents
        other = names[(names.index(agent) + 1) % len(names)]
        found["self"] = super().observe(other)["self"]
        return found


class KeepsItsFirstSeed(ColonyAEC):
    """Ignores the seed after the first reset."""

    seeded = False

    def reset(self, seed=None, options=None):
        super().reset(None if self.seeded else seed, options)
        self.seeded = True


class CountsFromTheLastQuestion(ColonyAEC):
    """dt since anybody was asked, not since this agent was."""

    def _take_over(self):
        super()._take_over()
        for name in self.agents:
            if self.infos[name]:
                self.infos[name]["dt"] = self.infos[name]["t"] - self.turns.begin


class PaysTwice(Turns):
    """Pays for every arrival twice."""

    def _end(self, event):
        if event.kind == "goal":
            self.paid = [2.0 * paid for paid in self.paid]
        super()._end(event)


class AsksTheDead(ColonyAEC):
    """Asks an agent once more after its episode has ended."""

    raised = False

    def reset(self, seed=None, options=None):
        self.raised = False
        super().reset(seed, options)

    def _take_over(self):
        super()._take_over()
        name = self.agent_selection
        if (self.terminations[name] or self.truncations[name]) and not self.raised:
            self.raised, self.terminations[name], self.truncations[name] = True, False, False


class OwnTies(Turns):
    """Lets those be asked first at one time whom the environment's own lots say, not the run's."""

    def _begin_run(self):
        super()._begin_run()
        begin = self.colony._begin_next

        def begun():
            found = begin()
            self.colony._episode.ties = Streams(99).draws("ties", len(self.scenario.agents))
            return found

        self.colony._begin_next = begun


class SharesTimes(Turns):
    """A fork notes when its agents decided where the original does."""

    def fork(self, seed=None):
        twin = super().fork(seed)
        twin._since, twin.ends = self._since, self.ends
        return twin
