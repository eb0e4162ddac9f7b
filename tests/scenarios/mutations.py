"""Scenario files that are wrong in one or two places: the shipped ones, changed at random from a fixed seed."""

# ruff: noqa: E501 - tables

from __future__ import annotations

import copy
import json
import random
from typing import Any

import yaml

from colonysim.scenario.loading import list_scenarios
from colonysim.scenario.source import read_text

NUMBERS = [
    0, -0.0, 1, -1, 2, 3, 0.1, 0.5, 1.5, 7, 10, 50, 99, 1e3, 1e5, 1e6, 10**6, 10**7, 1e9, 10**9, -1e9, 1e9 + 1, 2**31, 2**31 - 1, -(2**31),
    1e-320, 5e-324, 1e-300, 1e-12, 1e-9, 1e-6, 1e-4, 1e-3, 1e12, 10**15, 2**53, 2**63, 10**18 - 1, 10**18, 1e300, -1e300, 1.7e308,
]  # fmt: skip
OTHERS: list[Any] = [
    None, True, False, "", " ", "x", "²", "9" * 5000, "\x1b[31m", "a\nb", "a\tb", "\u202eabc", "é" * 300, "2020-01-01", "0x10", "1_000", "no",
    [], {}, [0], [0, 1], [0, 1, 2], [[0]], [[]], [None], {"": 1}, {"<list>": 1}, {"<mapping>": 1}, {"a.b": 1}, {"²": 1}, {"\x1b": 1},
    {"node": 0}, {"kind": "grid"}, {"name": "random"}, {"radius": 1.0}, {"count": 2, "seed": 1}, "os:system", [[[[[[[[1]]]]]]]],
    {"a": {"b": {"c": {"d": [1, {"e": 2}]}}}},
]  # fmt: skip
SNIPPETS = [
    "", " ", "\n", "\t", ":", ": ", "-", "- ", "[", "]", "{", "}", ",", "#", "&a ", "*a", "*a: ", "!!str ", "!!int ", "!!float ", "!!binary ", "!!set ",
    "!!timestamp ", "!!python/object:os.system ", "!x ", "!%1b ", "|\n", ">\n", "'", '"', "%", "%YAML 3.1\n", "@", "`", "null", ".nan", "-.inf", "1e400",
    "1e-400", "-1", "0", "007", "0o7", "99", "9" * 30, "9" * 5000, "1." + "0" * 5000, "true", "<<: ", "<<: *a\n", "? ", "? [a]\n: 1\n", "---\n", "...\n",
    "\x00", "\x1b", "\x7f", "\x85", "\u2028", "\u202e", "\ufeff", "\ufffe", "é", "²", "\U0001f600", "[" * 40, "[" * 3000, "{a: " * 40, "- " * 40,
    "- " * 3000, "? " * 3000, "&a [*a, *a]", "2020-01-01", '"\\ud800"', '"\\x1b"', '"\\0"', '"\\U00110000"', "a" * 2000 + ": 1\n", "goal: 3\n",
    "name: x\n", "a: &a [1,1,1,1,1,1,1,1,1]\nb: &b [*a,*a,*a,*a,*a,*a,*a]\nc: [*b,*b,*b,*b,*b,*b,*b,*b,*b,*b,*b,*b,*b]\n",
]  # fmt: skip
SECTIONS: dict[str, list[str]] = {
    "": ["detection_radius", "reach", "max_steps", "episodes", "stall_seconds", "time_limit", "goal"],
    "timing": ["travel", "push", "travel_fixed", "push_fixed", "jitter"],
    "physics": ["xy_scale", "z_scale", "box_length", "box_height", "box_mass", "box_friction", "pit_side", "ramp_half_width", "margin"],
    "policy": ["beta", "epsilon", "d_max", "box_decay", "box_start", "box_cap", "patience", "tries", "feasibility"],
}  # fmt: skip
_DUMPER = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
KINDS: dict[str, list[str]] = {
    "grid": ["columns", "rows", "spacing"],
    "line": ["nodes", "spacing"],
    "ring": ["nodes", "spacing"],
    "geometric": ["nodes", "radius", "seed", "width", "height", "apart"],
    "rooms": ["columns", "rows", "size", "seed", "spacing"],
}


def shipped_texts() -> list[str]:
    """The text of each scenario that comes with the package."""
    return [path.read_text(encoding="utf-8") for _, path, _, _ in list_scenarios()]


def mutations(count: int, seed: int) -> list[bytes]:
    """So many changed scenario files; the same seed gives the same ones."""
    rng, texts = random.Random(seed), shipped_texts()
    return [_mutation(rng, rng.choice(texts)) for _ in range(count)]


def _mutation(rng: random.Random, text: str) -> bytes:
    if rng.random() < 0.3:
        return _changed_text(rng, text)
    document, _ = read_text(text, "shipped")
    document.pop("variants", None)
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        rng.choice((_number, _number, _scale, _scale, _section, _section, _other, _list, _list, _key, _topology))(rng, document)
    return yaml.dump(document, Dumper=_DUMPER, sort_keys=False, allow_unicode=rng.random() < 0.5, width=10**6).encode("utf-8", "replace")


def _changed_text(rng: random.Random, text: str) -> bytes:
    for _ in range(rng.randint(1, 3)):
        at = rng.randrange(len(text))
        kind = rng.random()
        if kind < 0.6:
            text = text[:at] + rng.choice(SNIPPETS) + text[at + rng.randint(0, 5) :]
        elif kind < 0.8:
            lines = text.splitlines(keepends=True)
            line = rng.randrange(len(lines))
            lines[line : line + 1] = rng.choice(([], [lines[line]] * 2, [f" {lines[line]}"], [lines[line].lstrip()]))
            text = "".join(lines) or "\n"
        else:
            text = text[:at] + text[at + rng.randint(1, 200) :] or "\n"
    kind = rng.random()
    if kind < 0.05:
        return text.encode(rng.choice(("utf-16", "utf-16-le", "utf-32", "utf-8-sig")))
    data = text.encode("utf-8", "replace")
    if kind < 0.15:
        at = rng.randrange(len(data))
        data = data[:at] + bytes(rng.randrange(256) for _ in range(rng.randint(1, 4))) + data[at + 1 :]
    return data


def _places(value: Any) -> list[tuple[Any, Any]]:
    """Every (container, key) of a document."""
    found = []
    for key in list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ():
        found.append((value, key))
        found += _places(value[key])
    return found


def _some(rng: random.Random, document: Any, kind: type | tuple[type, ...] = object) -> tuple[Any, Any]:
    found = [(into, key) for into, key in _places(document) if isinstance(into[key], kind)]
    return rng.choice(found) if found else (document, "x")


def _number(rng: random.Random, document: Any) -> None:
    into, key = _some(rng, document, (int, float))
    into[key] = rng.choice(NUMBERS)


def _scale(rng: random.Random, document: Any) -> None:
    into, key = _some(rng, document, (float, int))
    if key != "x":
        into[key] = round(into[key] * rng.choice((0.5, 0.9, 1.1, 2.0)), 3) if isinstance(into[key], float) else into[key] + rng.choice((-1, 1))


def _section(rng: random.Random, document: Any) -> None:
    name = rng.choice(list(SECTIONS))
    if isinstance(document.get("policy"), str):
        document["policy"] = {"name": document["policy"]}
    into = document.setdefault(name, {}) if name else document
    if isinstance(into, dict):
        into[rng.choice(SECTIONS[name])] = rng.choice(NUMBERS)


def _other(rng: random.Random, document: Any) -> None:
    into, key = _some(rng, document)
    into[key] = copy.deepcopy(rng.choice(OTHERS))


def _list(rng: random.Random, document: Any) -> None:
    into, key = _some(rng, document, list)
    old = into.get(key, []) if isinstance(into, dict) else into[key]
    at = rng.randrange(len(old) + 1)
    new = rng.choice((old[:at], old[at:], old + old, old[:at] + old[at + 1 :], [*old, *old[:1]], [old], old * 30, old[::-1]))
    into[key] = json.loads(json.dumps(new))


def _key(rng: random.Random, document: Any) -> None:
    into, key = _some(rng, document)
    if isinstance(into, dict) and key in into:
        value = into.pop(key)
        if rng.random() < 0.7:
            words = ["", "<list>", "<plain>", "²", "a.b", "\x1b[1m", "é", "x" * 400, f"{key}s", str(key)[:-1], "<<", "0", "variants", "\u202e"]
            into[rng.choice(words)] = value


def _topology(rng: random.Random, document: Any) -> None:
    kind = rng.choice(list(KINDS))
    document.pop("nodes", None)
    document.pop("edges", None)
    usual = {"nodes": 40, "columns": 7, "rows": 6, "size": 3, "radius": 3.0, "seed": 1, "spacing": 1.0, "width": 8.0, "height": 8.0, "apart": 0.2}
    topology = {"kind": kind, **{field: usual[field] for field in KINDS[kind]}}
    for _ in range(rng.randint(0, 2)):
        # A million nodes are allowed, and take more than these tests have.
        topology[rng.choice(KINDS[kind])] = rng.choice([number for number in NUMBERS if number != 10**6])
    document["topology"] = topology
    if rng.random() < 0.6:
        document |= {"holes": [], "slopes": [], "boxes": [], "agents": rng.choice(([0], [0, 1], {"count": 3, "seed": 1})), "goal": rng.choice((5, 7, 9))}
        document.pop("physics", None)
