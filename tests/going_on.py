"""Goes on with saved colonies in a process of its own, and says what came of it.

Reads lines of JSON (path, arguments of `Colony.load`) and writes for each the hash of the rows that were still to come.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from typing import Any

from colonysim import Colony
from colonysim.trace.writer import TraceWriter


class Parted:
    """A sink that hashes all rows, and from a moment on the later ones for themselves."""

    def __init__(self) -> None:
        self.whole = TraceWriter(None, {})
        self.rest: TraceWriter | None = None

    def write(self, table: str, row: tuple[object, ...]) -> None:
        for writer in (self.whole, self.rest):
            if writer is not None:
                writer.write(table, row)

    def part(self) -> None:
        self.rest = TraceWriter(None, {})

    def hashes(self) -> tuple[str, str]:
        assert self.rest is not None
        return self.whole.finish("finished"), self.rest.finish("finished")


def elsewhere(saved: list[tuple[str, dict[str, Any]]], seed: int) -> list[str]:
    """What comes of saved colonies in a fresh process with that PYTHONHASHSEED."""
    lines = "".join(json.dumps(each) + "\n" for each in saved)
    done = subprocess.run(
        [sys.executable, "-W", "ignore", __file__], input=lines, capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONHASHSEED": str(seed), "PYTHONPATH": os.pathsep.join(sys.path)},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-3000:]
    return [line.split()[1] for line in done.stdout.splitlines() if line.startswith("hash ")]


if __name__ == "__main__":
    for line in sys.stdin:
        path, arguments = json.loads(line)
        writer = TraceWriter(None, {})
        with Colony.load(path, sink=writer, **arguments) as colony:
            for _ in colony:
                pass
        print("hash", writer.finish("finished"))
