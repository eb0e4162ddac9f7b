"""The study of a trail that persists (docs/studies.md), over many seeds: it runs the code of that page.

    python benchmarks/persistent_trail.py --seeds 40

Prints the page's table: for each half-life and share of insensitive ants in how many of the colonies the trail had
adapted by the end, and the median of the times of all, those that never adapted counted as longer than any.
"""

import argparse
import re
from pathlib import Path
from typing import Any

from colonysim.intervals import wilson
from colonysim.processes import results

PAGE = Path(__file__).parent.parent / "docs" / "studies.md"
HALF_LIVES, SHARES = (None, 600.0, 300.0, 120.0, 60.0), (0.0, 0.1, 0.2, 0.3)
FIRST = 7000


def study() -> dict[str, Any]:
    """What the page's code defines; its last line, which prints an example, is left out."""
    section = PAGE.read_text(encoding="utf-8").partition("## A trail that persists")[2].partition("\n## ")[0]
    names: dict[str, Any] = {}
    for block in re.findall(r"```python\n(.*?)```", section, re.DOTALL):
        exec(compile(block.partition("\nprint(")[0], str(PAGE), "exec"), names)
    return names


def play(task: tuple[float | None, float, int]) -> float | None:
    """Seconds until a colony has adapted, None if it never does."""
    time: float | None = study()["adapts"](*task)
    return time


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=40)
    parser.add_argument("--workers", type=int, default=2)
    asked = parser.parse_args()
    tasks = [(half_life, share, FIRST + n) for n in range(asked.seeds) for half_life in HALF_LIVES for share in SHARES]
    found: dict[tuple[float | None, float], list[float]] = {}
    for (half_life, share, _), time in results(play, tasks, asked.workers):
        found.setdefault((half_life, share), []).append(float("inf") if time is None else time)
    print(f"| half-life | {' | '.join(f'{share:.0%}' for share in SHARES)} |")
    print("|---" * (len(SHARES) + 1) + "|")
    for half_life in HALF_LIVES:
        cells = []
        for share in SHARES:
            times = sorted(found[half_life, share])
            adapted = sum(time < float("inf") for time in times)
            low, high = wilson(adapted, len(times))
            middle = times[len(times) // 2]
            told = f"{middle:.0f} s" if middle < float("inf") else "never"
            cells.append(f"{adapted / len(times):.2f} [{low:.2f}, {high:.2f}], {told}")
        print(f"| {'none' if half_life is None else f'{half_life:.0f} s'} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
