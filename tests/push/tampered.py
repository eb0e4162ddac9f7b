"""Model files that are not what they should be, made from a seed; and one process that shows them to every reader.

Run as a program it prints a line of JSON for each reader of each file, and last its own peak memory:

    python tests/push/tampered.py FOLDER FIRST LAST [push]

With `push`, what is accepted pushes boxes too.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import random
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from colonysim.bench.measuring import peak_mb
from colonysim.learning.cards import load_model

MODELS = {"push": "q-network", "feasibility": "forest", "way": "logistic"}
_ODD: list[Any] = [
    None, True, False, -1, 0, 1.5, 10**30, "", "x" * 5000, [], {}, [[]], [None], {"a": {}}, 2**63, "\u202e",
    [10**9] * 3,
]  # fmt: skip


def _npz(arrays: dict[str, np.ndarray], compress: bool = False) -> bytes:
    buffer = io.BytesIO()
    (np.savez_compressed if compress else np.savez)(buffer, **arrays)  # type: ignore[operator]
    return buffer.getvalue()


def _member(name: str, header: dict[str, Any], body: bytes, kind: int = zipfile.ZIP_DEFLATED) -> bytes:
    """An archive of one array whose header claims what it likes."""
    buffer, file = io.BytesIO(), io.BytesIO()
    np.lib.format.write_array_header_1_0(file, header)
    with zipfile.ZipFile(buffer, "w", kind) as packed:
        packed.writestr(f"{name}.npy", file.getvalue() + body)
    return buffer.getvalue()


def tampered(seed: int, folder: Path) -> tuple[str, Path]:
    """Writes a model; returns the shipped one that it was made from, and the path of its card."""
    chance = random.Random(seed)
    name = chance.choice(list(MODELS))
    model = load_model(name, MODELS[name])
    arrays = {key: array.copy() for key, array in model.arrays.items()}
    told: Any = json.loads(json.dumps(dict(model.card)))
    told["arrays"] = {key: list(array.shape) for key, array in arrays.items()}
    which = chance.choice(list(arrays))
    raw: bytes | None = None
    text: bytes | None = None
    sealed = True
    way = chance.randrange(16)
    if way == 0:  # a field of the card
        told[chance.choice(list(told))] = chance.choice(_ODD)
    elif way == 1:
        del told[chance.choice(list(told))]
    elif way == 2:
        told["arrays"][which] = chance.choice(_ODD)
    elif way == 3:  # numbers that are none, or too large for what they are calculated in
        wide = arrays[which].astype(chance.choice([np.float64, np.longdouble, np.float16]))
        with np.errstate(all="ignore"):
            wide.flat[0] = chance.choice([np.nan, np.inf, -np.inf, 1e300, -1e300, 3e38, -1.0, 2.0])
        arrays[which] = wide
    elif way == 4:  # another shape, told or not
        old = arrays[which]
        arrays[which] = chance.choice([old[:-1], old[None], np.zeros(0), np.zeros((0, 3)), np.float64(1.0)])
        if chance.random() < 0.5:
            told["arrays"][which] = list(np.shape(arrays[which]))
    elif way == 5:  # another type
        kind = chance.choice(["bool", "complex64", "S8", "datetime64[s]", "int64", "uint64", ">f4", "object"])
        arrays[which] = np.zeros(arrays[which].shape, dtype=kind)
    elif way == 6:  # indices that lead elsewhere
        arrays[which] = np.full(arrays[which].shape, chance.choice([-1, 10**9, 2**62, -(2**62)]), dtype=np.int64)
    elif way == 7:  # unpacks to much more
        shape = (chance.choice([10**6, 4 * 10**7, 1_250_000_000]),)
        told["arrays"] = {which: list(shape)}
        raw = _member(which, {"descr": "<f8", "fortran_order": False, "shape": shape}, bytes(2 * 10**8))
    elif way == 8:  # claims what is not there
        shape = chance.choice([(10**12,), (2**40, 2**40), (0, 10**30), (-5,), (10**6,)])
        told["arrays"] = {which: [max(0, n) for n in shape]}
        kind = chance.choice(["<f8", "|O", "<f4"])
        raw = _member(which, {"descr": kind, "fortran_order": False, "shape": shape}, b"x" * 64)
    elif way == 9:  # another way of packing, or thousands of files
        packing = chance.choice([zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
        raw = _member(which, {"descr": "<f8", "fortran_order": False, "shape": (3,)}, bytes(24), packing)
        if chance.random() < 0.5:
            buffer = io.BytesIO()
            with zipfile.ZipFile(buffer, "w") as packed:
                for number in range(20_000):
                    packed.writestr(f"{number}.npy", b"")
            raw = buffer.getvalue()
    elif way == 10:  # bytes that changed, the seal made anew
        whole = bytearray(_npz(arrays, chance.random() < 0.5))
        for _ in range(chance.choice([1, 5, 50])):
            at = chance.choice([chance.randrange(len(whole)), chance.randrange(300), -chance.randrange(1, 300)])
            whole[at] ^= 1 << chance.randrange(8)
        raw = bytes(whole)
    elif way == 11:  # cut off
        whole = _npz(arrays)
        raw = whole[: chance.randrange(len(whole))]
    elif way == 12:  # the card is no such JSON
        text = chance.choice([
            b"", b"null", b"[]", b"{", b"\xff\xfe", b"[" * 100_000, b'{"a":' * 5000 + b"1" + b"}" * 5000,
            b'{"format": 1e999}', b'{"format": ' + b"9" * 5000 + b"}", b'{"x": NaN}', b'"\\ud800"', b"\0" * 100,
        ])  # fmt: skip
    elif way == 13:  # the seal is wrong
        sealed = False
        told["sha256"] = chance.choice(["", "0" * 64, None, 5, "x" * 10_000])
    elif way == 14:  # one array more, or one less
        if chance.random() < 0.5:
            arrays["more"] = np.zeros(3)
        else:
            del arrays[which]
        if chance.random() < 0.5:
            told["arrays"] = {key: list(array.shape) for key, array in arrays.items()}
    card, data = folder / f"{seed}.json", folder / f"{seed}.npz"
    content = _npz(arrays) if raw is None else raw
    if sealed and isinstance(told, dict) and "sha256" in told:
        told["sha256"] = hashlib.sha256(content).hexdigest()
    data.write_bytes(content)
    card.write_bytes(json.dumps(told).encode() if text is None else text)
    if way == 15:  # something else in its place
        odd = chance.choice([card, data])
        odd.unlink()
        chance.choice([
            lambda: os.mkfifo(odd), odd.mkdir, lambda: odd.symlink_to(odd.name), lambda: odd.symlink_to("/dev/zero"),
            lambda: None,
        ])()  # fmt: skip
    return name, card


def readers(name: str, card: Path) -> dict[str, Callable[[], Any]]:
    """What reads such a model: the functions, and the commands by which a user names one."""
    from colonysim.push.executors import make_executor
    from colonysim.push.feasibility import load_feasibility
    from colonysim.push.network import load_network, network_ticks
    from colonysim.push.way import load_way_chance

    state = np.linspace(-1.0, 1.0, 9)
    if name == "feasibility":
        return {"load_feasibility": lambda: load_feasibility(card)(state)}
    if name == "way":
        return {"load_way_chance": lambda: load_way_chance(card)}
    out = card.with_suffix(".out")
    return {
        "load_network": lambda: load_network(card).values(state),
        "network_ticks": lambda: network_ticks(card),
        "make_executor": lambda: make_executor("rl", model=card),
        "evaluate": ["evaluate", "push", "--push", "rl", "-n", "1", "-q", "--model", str(card), "-o", str(out)],
        "feasibility": ["train", "feasibility", "--model", str(card), "--states", "200", "-q", "-o", str(out)],
        "way": ["train", "way", "--model", str(card), "--ways", "20", "-q", "-o", str(out)],
    }  # type: ignore[dict-item]


def main(folder: Path, first: int, last: int, push: bool) -> None:
    """Shows the models of some seeds to all their readers."""
    import warnings

    from typer.testing import CliRunner

    from colonysim.cli import app
    from colonysim.errors import ColonysimError

    warnings.simplefilter("error")
    accepted = 0
    for seed in range(first, last):
        name, card = tampered(seed, folder)
        ends = {}
        for reader, call in readers(name, card).items():
            try:
                if callable(call):
                    call()
                    end = [0, ""]
                # What is accepted is a network that pushes: the training commands would take minutes with it.
                elif (push and reader == "evaluate") or ends["load_network"][0] or ends["network_ticks"][0]:
                    done = CliRunner().invoke(app, call)
                    said = [line for line in done.output.splitlines() if line.strip()]
                    end = [done.exit_code, "\n".join(said) if done.exit_code else ""]
                else:
                    continue
            except ColonysimError as error:
                end = [2, f"Error: {error}"]
            except BaseException as error:
                end = [1, f"{type(error).__name__}: {error}"]
            ends[reader] = end
            print(json.dumps([seed, reader, *end]), flush=True)
        accepted += ends and not any(end[0] for end in ends.values())
    print(json.dumps({"accepted": accepted, "kilobytes": 1024 * (peak_mb() or 0.0)}))


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), "push" in sys.argv[4:])
