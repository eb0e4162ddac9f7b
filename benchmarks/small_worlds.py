"""Small worlds with boxes in each other's way: `colony` beside `random`, as a Markdown table by kind.

Run with: python benchmarks/small_worlds.py [--worlds 300] [--seed 3000] [--episodes 60] [--workers 2]
       [--policies random colony] [--save COUNTS] [--before COUNTS] [--table FILE]

To compare two versions, the first saves its counts and the second reads them: --save counts.json, then
--policies colony --before counts.json.

An episode counts if all agents reach the goal in it. Intervals are Wilson's, 95 %. The policy was tuned on the worlds
of seeds from 0 and from 2000 on.
"""

from __future__ import annotations

import argparse
import json
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from colonysim import scenario_from_document, simulate
from colonysim.errors import ColonysimError
from colonysim.files import replace_file
from colonysim.intervals import wilson
from colonysim.processes import results
from colonysim.testing.worlds import random_document

BOX = 0.35
SLOPE = 0.5
POLICIES = ("random", "colony")


def drawn(rows: list[str], depths: int | dict[int, int] = 1, **fields: Any) -> dict[str, Any]:
    """A scenario from a plan: `.` floor, `b` box, `B` a box of twice the height, `o` hole, `a` agent, `g` goal.

    Neighbours are one unit apart in the four directions; a blank is no node. `/` is a slope that rises to the right by
    half a unit, and what lies to the right of it in its row lies as high.

    Args:
        rows: The plan.
        depths: How many boxes deep the holes are; by their order, if it differs.
        fields: Further fields of the scenario.
    """
    ids: dict[tuple[int, int], int] = {}
    nodes: list[list[float]] = []
    holes: list[dict[str, float]] = []
    edges, slopes, boxes, agents, goal = [], [], [], [], -1
    heights: dict[tuple[int, int], float] = {}
    for y, row in enumerate(rows):
        height = 1.0
        for x, sign in enumerate(row):
            if sign == "/":
                height += SLOPE
            if sign == " ":
                continue
            node = ids[x, y] = len(ids)
            heights[x, y] = height
            nodes.append([node, float(x), float(-y), height])
            for other in ((x - 1, y), (x, y - 1)):
                if other in ids:
                    edges.append([ids[other], node])
                    if heights[other] != height:
                        slopes.append([ids[other], node])
            if sign == "o":
                deep = depths if isinstance(depths, int) else depths.get(len(holes), 1)
                holes.append({"node": node, "depth": round(deep * BOX, 2)})
            elif sign in "bB":
                boxes.append([node, BOX if sign == "b" else 2 * BOX])
            elif sign == "a":
                agents.append(node)
            elif sign == "g":
                goal = node
    return {
        "name": "plan", "nodes": nodes, "edges": edges, "slopes": slopes, "holes": holes, "boxes": boxes,
        "agents": agents, "goal": goal, "detection_radius": 20.0, "max_steps": 150, **fields,
    }  # fmt: skip


def floor(rng: random.Random, low: int, high: int) -> str:
    return "." * rng.randint(low, high)


def mixed(rng: random.Random, signs: str) -> str:
    return "".join(rng.sample(signs, len(signs)))


def row(rng: random.Random) -> dict[str, Any]:
    """Boxes one behind the other before a hole that takes some or all of them."""
    boxes = rng.randint(2, 4)
    gaps = "".join("b" + floor(rng, 0, 1) * (rng.random() < 0.3) for _ in range(boxes))
    return drawn(["a" + floor(rng, 0, 2) + gaps + floor(rng, 1, 2) + "og"], rng.randint(1, boxes))


def corridor(rng: random.Random) -> dict[str, Any]:
    """Boxes in a corridor between two rooms, more of them than its hole takes, or none that it needs."""
    boxes = rng.randint(1, 3)
    way = mixed(rng, "b" * boxes + floor(rng, 1, 3))
    hole = rng.choice(("o", "")) if boxes > 1 else ""
    middle = "a." + way + floor(rng, 1, 1) + hole + ".g"
    width = len(middle)
    wings = "." + "." + " " * (width - 4) + ".."
    return drawn([wings, middle] if rng.random() < 0.5 else [wings, middle, wings])


def behind(rng: random.Random) -> dict[str, Any]:
    """Agents between the hole and its boxes, which have to be taken from behind."""
    boxes = rng.randint(1, 3)
    tail = "".join("b" + floor(rng, 0, 1) for _ in range(boxes)) + floor(rng, 0, 2)
    return drawn(["go" + floor(rng, 0, 1) + "a" + floor(rng, 0, 2) + tail], rng.randint(1, boxes))


def two_holes(rng: random.Random) -> dict[str, Any]:
    """One approach to two holes, of which one leads to the goal or both in turn do."""
    boxes = rng.randint(2, 3)
    approach = "a" + mixed(rng, "b" * boxes + floor(rng, 1, 3)) + "."
    if rng.random() < 0.3:
        return drawn([approach + "o" + floor(rng, 0, 1) + "og"], {0: 1, 1: rng.randint(1, boxes - 1)})
    side = " " * (len(approach) - 1)
    plan = [approach + "og", side + "o" + floor(rng, 0, 2).replace(".", " ")]
    return drawn(plan if rng.random() < 0.5 else plan[::-1], rng.choice(({}, {0: 2})) if boxes > 2 else 1)


def pockets(rng: random.Random) -> dict[str, Any]:
    """A corridor with dead ends at its sides, in some of which there are boxes."""
    length = rng.randint(4, 6)
    middle = "a" + mixed(rng, "." * (length - 1) + rng.choice(("b", "."))) + "." + "og"
    sides = ["".join(rng.choice("b. ") if 0 < x <= length else " " for x in range(len(middle))) for _ in range(2)]
    # Dead ends do not touch each other.
    sides = ["".join(s if x % 2 else " " for x, s in enumerate(side)) for side in sides]
    plan = [sides[0], middle, sides[1]]
    have = sum(line.count("b") for line in plan)
    if not have:
        plan[1] = "ab" + middle[2:]
        have = plan[1].count("b")
    return drawn(plan, rng.randint(1, min(2, have)))


def junction(rng: random.Random) -> dict[str, Any]:
    """Arms that meet at a node with a box on it; the hole is in one arm, the goal at its end."""
    arms = [rng.choice(("b.", ".b", "..", "a.")) for _ in range(2)]
    up, down = arms
    width = rng.randint(1, 3)
    left = floor(rng, width, width)
    left = "a" + left if rng.random() < 0.7 or "a" not in up + down else "b" + left
    if "a" not in left + up + down:
        left = "a" + left
    at = len(left)
    boxes = 1 + up.count("b") + down.count("b") + left.count("b")
    plan = [" " * at + sign for sign in reversed(up)] + [left + "b" + floor(rng, 0, 1) + "og"]
    return drawn(plan + [" " * at + sign for sign in down], rng.randint(1, min(boxes, 3)))


def slope(rng: random.Random) -> dict[str, Any]:
    """Two levels with a slope between them; boxes stand on either."""
    boxes = rng.randint(1, 2)
    low = "a" + mixed(rng, "b" * boxes + floor(rng, 1, 2)) + "."
    high = "." + mixed(rng, rng.choice(("b", "")) + floor(rng, 1, 2)) + "og"
    first = low + "/" + high
    if rng.random() < 0.5:
        # The other way round: down.
        first = "go" + floor(rng, 1, 2) + "/" + floor(rng, 1, 2) + mixed(rng, "b" * boxes + floor(rng, 1, 2)) + "a"
    return drawn([first], rng.randint(1, boxes))


def crowd(rng: random.Random) -> dict[str, Any]:
    """Several agents in a room, boxes among them, a hole at the door."""
    agents, boxes = rng.randint(2, 4), rng.randint(1, 3)
    width, height = rng.randint(3, 4), rng.randint(2, 3)
    signs = mixed(rng, "a" * agents + "b" * boxes + "." * max(0, width * height - agents - boxes))[: width * height]
    if "b" not in signs:
        signs = "b" + signs[1:]
    if "a" not in signs:
        signs = signs[:-1] + "a"
    plan = [signs[i * width : (i + 1) * width] for i in range(height)]
    plan[rng.randrange(height)] += "og"
    return drawn(plan, rng.randint(1, min(2, sum(line.count("b") for line in plan))))


def small_radius(rng: random.Random) -> dict[str, Any]:
    """One of the kinds so far, with little of it in sight."""
    document = rng.choice((row, behind, two_holes, pockets, junction, crowd))(rng)
    return {**document, "detection_radius": rng.choice((1.2, 1.5, 2.0, 3.0))}


def tall(rng: random.Random) -> dict[str, Any]:
    """A box too high for the hole stands in the way of the others, or beside it."""
    order = "B" + "b" * rng.randint(1, 2)
    way = mixed(rng, order + floor(rng, 1, 2)) + "."
    middle = "a" + way + "og"
    side = "".join(rng.choice(". ") if 0 < x < len(middle) - 2 else " " for x in range(len(middle)))
    return drawn([side, middle])


def room(rng: random.Random) -> dict[str, Any]:
    """Rooms with boxes strewn about, walls of holes between them."""
    width, height = rng.randint(2, 4), rng.randint(2, 3)
    boxes = rng.randint(2, min(4, width * height - 2))
    agents = rng.randint(1, 2)
    signs = mixed(rng, "a" * agents + "b" * boxes + "." * (width * height - agents - boxes))
    plan = [signs[i * width : (i + 1) * width] for i in range(height)]
    ends = ["o" + rng.choice(("g", ".")) if i == 0 else rng.choice((" ", "o")) + "." for i in range(height)]
    ends = [end.replace("g", ".") for end in ends]
    ends[0] = "og"
    return drawn([line + end for line, end in zip(plan, ends, strict=True)], rng.choice((1, 1, 2)) if boxes > 2 else 1)


def one_way(rng: random.Random) -> dict[str, Any]:
    """One of the kinds so far, with some pushes forbidden."""
    document = rng.choice((row, behind, two_holes, pockets, junction, room))(rng)
    directed = [pair for edge in document["edges"] for pair in (edge, edge[::-1])]
    return {**document, "no_push": rng.sample(directed, min(len(directed), rng.randint(1, 3)))}


def any_place(rng: random.Random) -> dict[str, Any]:
    """Whatever the tests of policies make."""
    return {**random_document(rng), "max_steps": 100}


Maker = Callable[[random.Random], dict[str, Any]]
KINDS: dict[str, Maker] = {
    "boxes in a row": row, "boxes in a corridor": corridor, "taken from behind": behind, "two holes": two_holes,
    "side pockets": pockets, "box on a junction": junction, "slope": slope, "crowd": crowd,
    "small radius": small_radius, "too high a box": tall, "rooms": room, "one-way pushes": one_way,
    "anything": any_place,
}  # fmt: skip


def small_world(kind: str, seed: int) -> dict[str, Any]:
    """The world of a kind and a seed, as the document of a valid scenario."""
    rng = random.Random(f"{kind}/{seed}")
    while True:
        document = KINDS[kind](rng)
        document["name"] = f"{kind.replace(' ', '-')}-{seed}"
        document["max_steps"] = rng.choice((60, 120, 240)) if kind != "anything" else document["max_steps"]
        try:
            scenario_from_document(document)
        except ColonysimError:
            continue
        return document


class Job(NamedTuple):
    """A run of a world."""

    kind: str
    seed: int
    policy: str
    episodes: int


def play(job: Job) -> int:
    """In how many of its episodes all agents reach the goal."""
    scenario = scenario_from_document(small_world(job.kind, job.seed))
    events = simulate(scenario, policy=job.policy, episodes=job.episodes, seed=job.seed, kinds={"episode"})
    return sum(event.status == "goal" for event in events)


def jobs_for(policy: str, worlds: int, seed: int, episodes: int) -> list[Job]:
    """As many worlds of every kind, of seeds from `seed` on."""
    kinds = list(KINDS)
    return [Job(kinds[i % len(kinds)], seed + i // len(kinds), policy, episodes) for i in range(worlds)]


def share(successes: int, trials: int) -> str:
    low, high = wilson(successes, trials)
    return f"{successes / max(1, trials):.3f} [{low:.3f}, {high:.3f}]"


def table(counts: dict[str, list[int]], jobs: list[Job]) -> list[str]:
    """A row for each kind and one for all: worlds solved and the share of episodes in which all arrive."""
    names = list(counts)
    lines = [
        f"| kind | worlds | {' | '.join(f'solved by {name}' for name in names)} | by random, not by {names[-1]} | "
        f"fewer episodes than random | {' | '.join(f'episodes, {name}' for name in names)} |",
        "|---" * (2 * len(names) + 4) + "|",
    ]
    for kind in [*KINDS, "all"]:
        rows = [i for i, job in enumerate(jobs) if kind in (job.kind, "all")]
        if not rows:
            continue
        won = {name: [values[i] for i in rows] for name, values in counts.items()}
        chance, mine = won["random"], won[names[-1]]
        trials = len(rows) * jobs[0].episodes
        cells = [kind, str(len(rows)), *(str(sum(n > 0 for n in values)) for values in won.values())]
        cells.append(str(sum(a > 0 and b == 0 for a, b in zip(chance, mine, strict=True))))
        cells.append(str(sum(b < a for a, b in zip(chance, mine, strict=True))))
        cells += [share(sum(values), trials) for values in won.values()]
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def exceptions(counts: dict[str, list[int]], jobs: list[Job]) -> list[str]:
    """The worlds in which the last policy does worse than random."""
    name = list(counts)[-1]
    return [
        f"- {job.kind}, seed {job.seed}: `random` {a}, {name} {b} of {job.episodes} episodes"
        for job, a, b in zip(jobs, counts["random"], counts[name], strict=True)
        if b < a
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--worlds", type=int, default=300)
    parser.add_argument("--seed", type=int, default=3000)
    parser.add_argument("--episodes", type=int, default=60)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--policies", nargs="+", default=POLICIES)
    parser.add_argument("--save", type=Path, metavar="FILE", help="keep the counts for a later table")
    parser.add_argument("--before", type=Path, metavar="FILE", help="counts of `colony` that an earlier version saved")
    parser.add_argument("--table", type=Path, metavar="FILE", help="write the table there, not to the screen")
    args = parser.parse_args()
    counts: dict[str, list[int]] = {}
    if args.before:
        earlier = json.loads(args.before.read_text(encoding="utf-8"))
        counts |= {("colony before" if name == "colony" else name): values for name, values in earlier.items()}
    for policy in args.policies:
        jobs = jobs_for(policy, args.worlds, args.seed, args.episodes)
        won = dict(results(play, jobs, args.workers))
        counts[policy] = [won[job] for job in jobs]
    if args.save:
        replace_file(args.save, json.dumps(counts).encode())
    if "random" not in counts:
        parser.error("the table compares with random: name it in --policies or have it in --before")
    lines = [*table(counts, jobs), "", *(exceptions(counts, jobs) or ["No world in which it does worse than random."])]
    text = "\n".join(lines) + "\n"
    if args.table:
        replace_file(args.table, text.encode())
    else:
        print(text, end="")


if __name__ == "__main__":
    main()
