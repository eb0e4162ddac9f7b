"""How large the page of a run is, how soon it shows something, and how smoothly it plays with 10,000 agents.

Frames are counted in the page itself, against an empty canvas loop of the same size in the same browser. Needs
chromium, chromium-driver and selenium.

Run with: python benchmarks/view_page.py [--agents 10000] [--side 150]
"""

from __future__ import annotations

import argparse
import random
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import colonysim
from colonysim.view import write_page

# The tests know how to start the browser.
sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "view"))
from chromium import chromium, show

LARGEST, LATEST, LEAST = 3e6, 2.0, 30.0
"""Bytes of the page of hard with 30 episodes, seconds until it shows something, frames a second."""
COUNT = """
    const done = arguments[1], seconds = arguments[0], first = performance.now();
    let frames = 0;
    const frame = (now) => {
      DRAW
      frames++;
      if (now - first < 1000 * seconds) requestAnimationFrame(frame);
      else done(frames / ((now - first) / 1000));
    };
    requestAnimationFrame(frame);
"""
EMPTY = COUNT.replace("DRAW", "pen.clearRect(0, 0, canvas.width, canvas.height); pen.fillRect(frames % 99, 9, 9, 9);")
CANVAS = """
    const canvas = document.createElement("canvas"), pen = canvas.getContext("2d");
    canvas.width = innerWidth; canvas.height = innerHeight; document.body.append(canvas);
"""


def frames(session: Any, seconds: float) -> float:
    """Frames a second that the page draws while it plays; each frame of it is one of the browser's."""
    begun = session.execute_script("return [performance.now(), window.colonysim.frames]")
    time.sleep(seconds)
    ended = session.execute_script("return [performance.now(), window.colonysim.frames]")
    return 1000 * float(ended[1] - begun[1]) / float(ended[0] - begun[0])


def crowd(agents: int, side: int) -> Any:
    goal = side * side - 1
    starts = random.Random(0).sample(range(goal), agents)
    document = {
        "name": "crowd", "topology": {"kind": "grid", "columns": side, "rows": side}, "agents": starts, "goal": goal,
        "max_steps": 10, "episodes": 1,
    }  # fmt: skip
    return colonysim.scenario_from_document(document)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--agents", type=int, default=10_000)
    parser.add_argument("--side", type=int, default=150)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, chromium() as session:
        root = Path(folder)
        hard = write_page(colonysim.run("hard", seed=10, episodes=30, out=root / "hard"), root / "hard.html")
        loads = []
        for _ in range(5):
            show(session, hard)
            mark = session.execute_script("return performance.getEntriesByName('first frame')[0].startTime")
            loads.append(mark / 1000)
        load, size = statistics.median(loads), hard.stat().st_size
        print(f"hard, 30 episodes: {size / 1e6:.2f} MB, first frame after {load:.2f} s (median of 5)")
        run = colonysim.run(crowd(asked.agents, asked.side), seed=10, out=root / "crowd")
        page = write_page(run, root / "crowd.html")
        rows = run.manifest["rows"]
        size_of_crowd = page.stat().st_size / 1e6
        print(f"{asked.agents} agents, {asked.side**2} nodes, {rows['events']} events: {size_of_crowd:.1f} MB")
        session.get("about:blank")
        empty = float(session.execute_async_script(CANVAS + EMPTY, 4))
        show(session, page)
        session.execute_script("document.getElementById('speed').value = 0.5; window.colonysim.play(true)")
        rates = {"all of it in view": frames(session, 4)}
        session.execute_script("window.colonysim.showField('D')")
        rates["with a pheromone"] = frames(session, 4)
        session.execute_script("window.colonysim.map.camera.zoom(4)")
        rates["close up, with a pheromone"] = frames(session, 4)
    for name, rate in rates.items():
        print(f"{name}: {rate:.0f} frames a second, {rate / empty:.2f} of an empty canvas loop's {empty:.0f}")
    return 0 if size <= LARGEST and load <= LATEST and min(rates.values()) >= LEAST else 1


if __name__ == "__main__":
    sys.exit(main())
