"""How long `colonysim --help` takes, against `import typer, rich`, which it cannot do without.

Run with: python benchmarks/cli_start.py [rounds]. Fails if help takes more than twice as long.
"""

from __future__ import annotations

import subprocess
import sys
import time

COMMANDS = {
    "python -c 'import typer, rich'": [sys.executable, "-c", "import typer, rich"],
    "colonysim --help": [sys.executable, "-m", "colonysim", "--help"],
    "colonysim run --help": [sys.executable, "-m", "colonysim", "run", "--help"],
}


def seconds(command: list[str]) -> float:
    begin = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - begin


def main() -> None:
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 15
    # In turns, and the fastest of each: what else the machine does then falls on all alike.
    best = {name: min(column) for name, column in zip(COMMANDS, zip(*(
        [seconds(command) for command in COMMANDS.values()] for _ in range(rounds)
    ), strict=True), strict=True)}  # fmt: skip
    base = next(iter(best.values()))
    for name, value in best.items():
        print(f"{name:32s} {value * 1000:6.0f} ms  {value / base:.2f} x")
    # The help of a command that takes numbers in a range also imports pydantic, through Typer.
    if best["colonysim --help"] > 2 * base:
        raise SystemExit("slower than twice the imports")


if __name__ == "__main__":
    main()
