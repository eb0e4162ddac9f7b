"""Networks in ONNX files, run by ONNX Runtime (extra `onnx`): a graph from numbers to numbers, and no code."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from colonysim.errors import MissingExtraError
from colonysim.installing import install_command
from colonysim.learning.cards import ModelError
from colonysim.learning.layers import Float

__all__ = ["OnnxGraph"]

_PROBES = 16
"""So many inputs are tried when a file is opened: outputs that are no numbers are refused before anything runs."""


class OnnxGraph:
    """A network of one input, float32 of shape (n, inputs), and one output of shape (n, outputs).

    Args:
        file: The file, for messages.
        content: Its bytes.
        inputs: Widths of the input that would fit.
        outputs: Width of the output.

    Attributes:
        inputs: Width of the input.
        metadata: What the file's author says about it.

    Raises:
        MissingExtraError: ONNX Runtime is not installed.
        ModelError: It is damaged, has other inputs or outputs, or gives values that are no finite numbers.
    """

    def __init__(self, file: Path, content: bytes, inputs: Sequence[int], outputs: int) -> None:
        self._file = file
        try:
            import onnxruntime
        except ImportError as error:
            raise MissingExtraError(f"{file}: needs ONNX Runtime ({error}): {install_command('onnx')}") from error
        options = onnxruntime.SessionOptions()
        # One thread: as fast for so small a network, and sums are added in one order.
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        options.log_severity_level = 4
        try:
            self._session = onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"])
        except Exception as error:  # its classes of errors have no common base
            raise ModelError(f"{file}: is no ONNX model that can be run: {_told(error)}") from None
        self.inputs = self._check_ends(inputs, outputs)
        self.metadata: dict[str, str] = dict(self._session.get_modelmeta().custom_metadata_map)
        self._name = self._session.get_inputs()[0].name
        probes = np.random.default_rng(0).normal(size=(_PROBES, self.inputs)).astype(np.float32)
        probes[0] = 0.0
        if self.forward(probes[0]).shape != (outputs,) or self.forward(probes).shape != (_PROBES, outputs):
            raise ModelError(f"{file}: gives other shapes than (n, {outputs}) for inputs of shape (n, {self.inputs})")

    def _check_ends(self, inputs: Sequence[int], outputs: int) -> int:
        """The width of the input; refuses other inputs and outputs than those that are expected."""
        for what, ends, widths in (
            ("input", self._session.get_inputs(), inputs), ("output", self._session.get_outputs(), (outputs,)),
        ):  # fmt: skip
            expected = f"expected one {what} of type tensor(float) and shape (n, {' or '.join(map(str, widths))})"
            shown = ", ".join(f"{end.name!r:.40}: {end.type} {end.shape}" for end in ends)[:200] or "none"
            if len(ends) != 1 or ends[0].type != "tensor(float)" or len(ends[0].shape) != 2:
                raise ModelError(f"{self._file}: has the {what}s {shown}; {expected}")
            rows, width = ends[0].shape
            # A size that is no number is open.
            if (isinstance(width, int) and width not in widths) or (isinstance(rows, int) and rows != 1):
                raise ModelError(f"{self._file}: has the {what} {shown}; {expected}, n open or 1")
        width = self._session.get_inputs()[0].shape[1]
        if not isinstance(width, int) and len(inputs) > 1:
            raise ModelError(f"{self._file}: does not say the width of its input; expected one of {list(inputs)}")
        return width if isinstance(width, int) else inputs[0]

    def forward(self, inputs: Float) -> Float:
        """The outputs.

        Args:
            inputs: Shape (k,) or (n, k).

        Raises:
            ModelError: It cannot be run, or a value is no finite number.
        """
        rows = inputs if inputs.ndim == 2 else inputs[np.newaxis]
        alone = isinstance(self._session.get_inputs()[0].shape[0], int)
        found = np.concatenate([self._run(row[np.newaxis]) for row in rows]) if alone else self._run(rows)
        if not np.isfinite(found).all():
            raise ModelError(f"{self._file}: gives a value that is no finite number")
        return found if inputs.ndim == 2 else found[0]

    def _run(self, rows: Float) -> Float:
        try:
            found: Any = self._session.run(None, {self._name: rows})[0]
        except Exception as error:  # as above
            raise ModelError(f"{self._file}: cannot be run: {_told(error)}") from None
        made: Float = found
        return made


def _told(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0][:200]
