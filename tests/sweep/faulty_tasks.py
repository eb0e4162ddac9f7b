"""Work for processes; they import it by name."""

from __future__ import annotations

import ctypes
import os
import time
from pathlib import Path


def half(number):
    return number / 2


def number_of_process(_):
    return os.getpid()


def hang(how):
    Path(f"begun-{os.getpid()}").touch()
    if how == "hold":  # in C, with the interpreter's lock
        ctypes.PyDLL(None).sleep(3600)
    while True:
        if how == "sleep":
            time.sleep(3600)
