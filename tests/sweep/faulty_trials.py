"""Policies that no sweep should have to suffer from; the processes of a sweep import them by name."""

from __future__ import annotations

import os
import signal
import time

from colonysim.policies.stigmergy import Stigmergy


class Raises(Stigmergy):
    def decide(self, view, memory, random):
        raise RuntimeError("out of ideas")


class Hangs(Stigmergy):
    def decide(self, view, memory, random):
        time.sleep(3600)


class Eats(Stigmergy):
    def decide(self, view, memory, random):
        self.eaten = getattr(self, "eaten", [])
        while True:
            self.eaten.append(bytearray(20_000_000))


class Dies(Stigmergy):
    def decide(self, view, memory, random):
        os.kill(os.getpid(), signal.SIGKILL)
