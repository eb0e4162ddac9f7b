"""Policies that no sweep should have to suffer from; the processes of a sweep import them by name."""

from __future__ import annotations

import ctypes
import os
import signal
import time

from colonysim.policies.stigmergy import Stigmergy


class Dawdles(Stigmergy):
    """Does what it should, after a while."""

    def __init__(self, scenario):
        time.sleep(0.15)
        super().__init__(scenario)


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


class Leaves(Stigmergy):
    def decide(self, view, memory, random):
        raise SystemExit(3)


class Interrupts(Stigmergy):
    def decide(self, view, memory, random):
        raise KeyboardInterrupt


class Spins(Stigmergy):
    def decide(self, view, memory, random):
        while True:
            pass


class Holds(Stigmergy):
    """Hangs in C, and keeps the interpreter's lock meanwhile."""

    def decide(self, view, memory, random):
        ctypes.PyDLL(None).sleep(3600)


class Shuts(Stigmergy):
    """Hangs, and does not listen to whoever asks it to end."""

    def decide(self, view, memory, random):
        for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT):
            signal.signal(number, signal.SIG_IGN)
        while True:
            time.sleep(3600)
