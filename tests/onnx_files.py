"""ONNX files of perceptrons, written byte by byte: the tests need no package that writes them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np


def _number(value: int) -> bytes:
    made = b""
    while value > 127:
        made += bytes([value & 127 | 128])
        value >>= 7
    return made + bytes([value])


def _field(number: int, value: int | str | bytes) -> bytes:
    if isinstance(value, int):
        return _number(number << 3) + _number(value)
    content = value.encode() if isinstance(value, str) else value
    return _number(number << 3 | 2) + _number(len(content)) + content


def _tensor(name: str, array: np.ndarray) -> bytes:
    dims = b"".join(_field(1, size) for size in array.shape)
    return dims + _field(2, 1) + _field(8, name) + _field(9, array.astype("<f4").tobytes())


def _end(name: str, shape: Sequence[int | str], kind: int = 1) -> bytes:
    dims = b"".join(_field(1, _field(1 if isinstance(size, int) else 2, size)) for size in shape)
    return _field(1, name) + _field(2, _field(1, _field(1, kind) + _field(2, dims)))


def _node(kind: str, inputs: Sequence[str], output: str, **attributes: int) -> bytes:
    told = b"".join(_field(5, _field(1, k) + _field(3, v) + _field(20, 2)) for k, v in attributes.items())
    return b"".join(_field(1, name) for name in inputs) + _field(2, output) + _field(4, kind) + told


def perceptron(
    layers: Sequence[tuple[np.ndarray, np.ndarray]],
    *,
    activation: str = "Relu",
    rows: int | str = "n",
    inputs: int | None = None,
    outputs: int | None = None,
    kind: int = 1,
    more_outputs: bool = False,
    metadata: Mapping[str, str] | None = None,
) -> bytes:
    """The bytes of a file; what is said of its ends need not be true."""
    graph, value = b"", "told"
    for n in range(len(layers)):
        last = n == len(layers) - 1
        graph += _field(1, _node("Gemm", [value, f"w{n}", f"b{n}"], "values" if last else f"z{n}", transB=1))
        if not last:
            graph += _field(1, _node(activation, [f"z{n}"], f"a{n}"))
            value = f"a{n}"
    graph += _field(2, "perceptron")
    for n, (weights, biases) in enumerate(layers):
        graph += _field(5, _tensor(f"w{n}", weights)) + _field(5, _tensor(f"b{n}", biases))
    graph += _field(11, _end("told", (rows, inputs or layers[0][0].shape[1]), kind))
    graph += _field(12, _end("values", (rows, outputs or layers[-1][0].shape[0])))
    if more_outputs:
        graph += _field(12, _end("z0", (rows, layers[0][0].shape[0])))
    about = b"".join(_field(14, _field(1, k) + _field(2, v)) for k, v in (metadata or {}).items())
    return _field(1, 8) + _field(7, graph) + _field(8, _field(2, 13)) + about
