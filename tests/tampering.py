"""Run directories that somebody or something has changed: a byte, a field, a cell, a file, from a seed."""

from __future__ import annotations

import json
import os
import random
import shutil
import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
from recorded_runs import manifest
from typer.testing import CliRunner

import colonysim
from colonysim.cli import app
from colonysim.simulation import simulate
from colonysim.sweep.tables import _write
from colonysim.trace.manifest import begin_manifest
from colonysim.trace.schema import EpisodeResult, Event
from colonysim.trace.writer import TraceWriter

ODD: list[Any] = [
    None, True, -1, 0, 10**6, 2**63, -(2**63), 10**30, 0.5, float("nan"), float("inf"), -1e308, "",
    "\x1b[31mred\x1b[0m",
    "evil:P", "../../up", "[bold]x[/bold]", "$\\frac{$ $", "a" * 5000, "\ud800", [], {}, [[]], [None], {"a": None},
    {"by_box": 1}, "0" * 64, "running",
    "finished",
]  # fmt: skip


def make_bases(folder: Path) -> list[Path]:
    """Runs of every kind, and a sweep: what is tampered with."""
    bases = [folder / name for name in ("nodes", "killed", "bodies", "pushes", "sweep")]
    nodes, killed, bodies, pushes, sweep = bases
    colonysim.run("sanity", seed=2, episodes=3, out=nodes)
    shutil.copytree(nodes, killed)
    told = json.loads((killed / "manifest.json").read_text())
    (killed / "manifest.json").write_text(json.dumps(told | {"status": "running", "rows": {}, "trace_sha256": None}))
    _with_poses(bodies)
    _single_pushes(pushes)
    sweep.mkdir()
    about = [{"trial": f"{name}{seed}", "scenario": "sanity", "policy": name, "seed": seed}
             for seed in (0, 1) for name in ("colony", "paper")]  # fmt: skip
    rest = {"status": "succeeded", "error": None, "episodes": 2, "success": 1.0, "steps": 9.0, "seconds": 0.1}
    _write(sweep / "trials.parquet", [{**each, **rest} for each in about])
    played = [{**each, "episode": n, "steps": 9, "success": 1.0, "ended": "goal", "sim_seconds": 4.5, "seated": 0}
              for each in about for n in (1, 2)]  # fmt: skip
    _write(sweep / "episodes.parquet", played)
    return bases


def _with_poses(path: Path) -> None:
    """A run as a physics backend would leave it."""
    scenario = colonysim.load_scenario("sanity")
    path.mkdir()
    about = begin_manifest(
        "sanity", backend="bullet", policy="colony", mode="asynchronous", episodes=2, seed=3, scenario=scenario
    )
    with TraceWriter(path, about, rows_per_part=30) as writer:
        for event in simulate(scenario, episodes=2, seed=3, sink=writer):
            if event.kind in ("start", "end"):
                x, y = scenario.topology.x[event.agent], scenario.topology.y[event.agent]
                at = (event.episode, event.time)
                writer.write("poses", (*at, "agent", event.agent, x, y, 0.0, 0.0, 0.0, event.time))
                for box in range(len(scenario.boxes)):
                    writer.write("poses", (*at, "box", box, x, y + box, 0.2, 0.0, 0.0, 0.0))
                writer.write("controls", (*at, event.agent, "script", "forward", 10))


def _single_pushes(path: Path) -> None:
    path.mkdir()
    pit = {"x": 1.0, "y": 0.0, "yaw": 0.0, "side": 1.2}
    ramp = {"x0": 0.0, "y0": 0.0, "z0": 0.0, "x1": 1.0, "y1": 0.0, "z1": 0.3, "half_width": 1.0}
    ground = {"box_length": 0.5, "start": [0.0, 0.0], "goal": [1.0, 0.0]}
    kinds = (("flat", [], []), ("slope", [], [ramp]), ("hole", [pit], []))
    pushes = [{"episode": i, "terrain": kind, "pits": pits, "ramps": ramps, **ground}
              for i, (kind, pits, ramps) in enumerate(kinds, 1)]  # fmt: skip
    evaluation = {"executor": "rl", "robot_size": [0.6, 0.4], "pushes": pushes}
    with TraceWriter(path, manifest(evaluation=evaluation)) as writer:
        for number in (1, 2, 3):
            for i in range(5):
                for body, ahead in (("agent", 0.0), ("box", 0.6)):
                    writer.write("poses", (number, i / 10, body, 0, ahead + i / 10, 0.0, 0.0, 0.0, 0.0, 0.0))
            end = Event(number, 0.5, "end", 0, "push", box=0, status="failed", reason="timeout", step=1)
            writer.write("events", end)
            writer.write("episodes", EpisodeResult(number, 1, float(number == 1), "timeout", 0.5, 0, 0.1))


def tamper(directory: Path, rng: random.Random) -> str:
    """Changes one thing, or two, of a directory; says what."""
    told = [rng.choice(_WAYS)(directory, rng) for _ in range(rng.choice((1, 1, 1, 2)))]
    return "; ".join(told)


def _files(directory: Path) -> list[Path]:
    return sorted(path for path in directory.rglob("*") if path.is_file())


def _bytes(directory: Path, rng: random.Random) -> str:
    path = rng.choice(_files(directory) or [directory / "manifest.json"])
    content = bytearray(path.read_bytes() if path.is_file() else b"x") or bytearray(b"x")
    kind = rng.choice(("flip", "flip", "flip", "footer", "cut", "zero", "more", "empty", "garbage"))
    if kind in ("flip", "footer"):
        first = max(0, len(content) - 900) if kind == "footer" else 0
        for _ in range(rng.choice((1, 2, 8, 30))):
            content[rng.randrange(first, len(content))] = rng.randrange(256)
    elif kind == "cut":
        del content[rng.randrange(len(content)) :]
    elif kind == "zero":
        at = rng.randrange(len(content))
        content[at : at + 64] = bytes(len(content[at : at + 64]))
    elif kind == "more":
        content += rng.randbytes(50)
    else:
        content = bytearray() if kind == "empty" else bytearray(rng.randbytes(500))
    path.unlink(missing_ok=True)
    path.write_bytes(content)
    return f"{kind} {path.name}"


def _shape(directory: Path, rng: random.Random) -> str:
    """Files that are gone, elsewhere, or no files."""
    path = rng.choice(_files(directory) or [directory / "manifest.json"])
    kind = rng.choice(("gone", "table", "swap", "twice", "pipe", "folder", "loop", "device", "socket", "gap"))
    if kind == "table" and path.parent != directory:
        shutil.rmtree(path.parent)
    elif kind in ("swap", "twice"):
        other = rng.choice(_files(directory) or [path])
        a, b = path.read_bytes(), other.read_bytes()
        path.write_bytes(b)
        if kind == "swap":
            other.write_bytes(a)
    elif kind == "gap":
        path.rename(path.with_name(f"part-{rng.randrange(20):05d}.parquet"))
    else:
        path.unlink(missing_ok=True)
        if kind == "pipe":
            os.mkfifo(path)
        elif kind == "folder":
            path.mkdir()
        elif kind == "loop":
            path.symlink_to(path.name)
        elif kind == "device":
            path.symlink_to("/dev/zero")
        elif kind == "socket" and len(str(path)) < 100:
            with socket.socket(socket.AF_UNIX) as made:
                made.bind(str(path))
    return f"{kind} {path.name}"


def _field(directory: Path, rng: random.Random) -> str:
    """Another value in the manifest, at any depth."""
    path = directory / "manifest.json"
    try:
        document = json.loads(path.read_bytes()) if path.is_file() else None
    except (ValueError, RecursionError):
        document = None
    if not isinstance(document, dict) or not document:
        return _bytes(directory, rng)
    here: Any = document
    where = []
    while True:
        key = rng.choice(list(here) if isinstance(here, dict) else list(range(len(here))))
        where.append(str(key))
        if not isinstance(here[key], (dict, list)) or not here[key] or rng.random() < 0.4:
            break
        here = here[key]
    kind = rng.choice(("odd", "odd", "odd", "gone", "more"))
    if kind == "gone":
        del here[key]
    elif kind == "more" and isinstance(here, dict):
        here[rng.choice(("evil:P", "\x1b[2J", "policy", "", "a" * 3000))] = rng.choice(ODD)
    else:
        here[key] = rng.choice(ODD)
    text = json.dumps(document)
    if rng.random() < 0.05:
        text = text[:-1] + ', "deep": ' + "[" * 100_000 + "]" * 100_000 + "}"
    path.write_text(text)
    return f"{kind} {'.'.join(where)}"


def _cell(directory: Path, rng: random.Random) -> str:
    """Another value, type or number of rows in a table; the manifest may count them as they are then."""
    parts = [path for path in _files(directory) if path.suffix == ".parquet"]
    if not parts:
        return _bytes(directory, rng)
    path = rng.choice(parts)
    try:
        table = pq.ParquetFile(path).read()
    except (OSError, ValueError, KeyError):
        return _bytes(directory, rng)
    if not table.num_rows:
        return _bytes(directory, rng)
    name = rng.choice(table.column_names)
    at, values, before = table.column_names.index(name), table[name].to_pylist(), table.num_rows
    kind = rng.choice(("cell", "cell", "cell", "type", "gone", "fewer", "more", "name", "all"))
    if kind == "cell":
        row, now = rng.randrange(len(values)), values[0]
        odd = [value for value in (*ODD, 5, 99, 1e300, "agent", "end", "goal") if _fits(value, now)]
        values[row] = rng.choice([*odd, None]) if not isinstance(now, list) else rng.choice([[], None, [99] * 3, [-7]])
        try:
            table = table.set_column(at, name, pa.array(values, type=table[name].type))
        except (pa.ArrowException, OverflowError, UnicodeEncodeError):
            return _bytes(directory, rng)
    elif kind == "all":
        table = table.set_column(at, name, pa.array([values[0]] * before, type=table[name].type))
    elif kind == "type":
        other = rng.choice([[str(v) for v in values], [None] * before, [{"a": 1}] * before, [b"\xff\xfe"] * before,
                            [float(i) for i in range(before)]])  # fmt: skip
        table = table.set_column(at, name, pa.array(other))
    elif kind == "gone":
        table = table.drop_columns([name])
    elif kind == "name":
        table = table.rename_columns([f"{each}x" if each == name else each for each in table.column_names])
    else:
        table = table.slice(0, rng.randrange(before)) if kind == "fewer" else pa.concat_tables([table] * 3)
    pq.write_table(table, path, store_schema=False)
    if rng.random() < 0.5:
        _recount(directory, path.parent.name, table.num_rows - before)
    return f"{kind} {path.parent.name}/{path.name} {name}"


def _fits(value: Any, like: Any) -> bool:
    if isinstance(like, bool) or isinstance(value, bool):
        return isinstance(value, bool)
    return isinstance(value, (int, float) if isinstance(like, float) else type(like))


def _recount(directory: Path, table: str, more: int) -> None:
    path = directory / "manifest.json"
    try:
        document = json.loads(path.read_text())
        document["rows"][table] += more
        path.write_text(json.dumps(document))
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        pass


_WAYS: list[Callable[[Path, random.Random], str]] = [_bytes, _shape, _field, _field, _cell, _cell]


def api(directory: Path) -> None:
    """Everything that a program reads of a run."""
    run = colonysim.Run.open(directory)
    assert run.status and run.episodes is not None and (run.trace_sha256 or run.status)
    for name in ("events", "decisions", "deposits", "poses", "controls", "frames", "episodes"):
        run.table(name).to_pylist()
    for _ in run.events():
        pass
    run.check_places()
    run.field("D")


def command(*words: object) -> Callable[[Path, Path], Any]:
    """A reader on the command line; DIR and OUT stand for the directory and a folder to write to."""

    def call(directory: Path, out: Path) -> Any:
        said = [str(word).replace("DIR", str(directory)).replace("OUT", str(out)) for word in words]
        return CliRunner().invoke(app, said)

    return call


QUICK = {
    "verify": command("verify", "DIR"),
    "report": command("report", "DIR", "--json"),
    "export csv": command("export", "DIR", "decisions", "-o", "OUT/t.csv"),
    "export": command("export", "DIR", "frames", "-f", "json"),
    "compare": command("compare", "DIR", "OUT/other"),
    "results": command("results", "DIR"),
    "view": command("view", "DIR", "--no-open", "-o", "OUT/v.html"),
}
SLOW = {
    "plot map": command("plot", "DIR", "-w", "map,D", "-o", "OUT/plots"),
    "plot": command("plot", "DIR", "-o", "OUT/plots"),
    "video": command("video", "DIR", "OUT/v.gif", "--seconds", 0.2, "--fps", 10, "--size", "160x160", "--overwrite"),
    "rrd": command("export", "DIR", "-o", "OUT/t.rrd"),
}
