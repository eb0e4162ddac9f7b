"""Tables of figures, kept as a file to compare later ones with."""

from __future__ import annotations

import dataclasses
import importlib.metadata
import json
import os
import platform
import statistics
from pathlib import Path
from typing import TYPE_CHECKING, Any

import colonysim
from colonysim.bench.cases import CASES
from colonysim.bench.measuring import Figures
from colonysim.built import build
from colonysim.errors import ColonysimError
from colonysim.files import replace_file

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["compared", "report", "save", "shares", "stored"]

FORMAT = 1


def report(figures: Sequence[Figures]) -> dict[str, Any]:
    """Figures with the facts of the machine, as one JSON document.

    Args:
        figures: One for each case.
    """
    return {"format": FORMAT, "machine": _machine(), "rows": [_row(f) for f in figures]}


def shares(figures: Sequence[Figures]) -> dict[str, float]:
    """What a user brings beside what is built in: by case, its decisions a timeout over those of the case beside it.

    Args:
        figures: Cases whose `beside` is not among them are left out.
    """
    ratios = {each.case: each.decision_ratio for each in figures}
    return {
        name: ratio / ratios[beside]
        for name, ratio in ratios.items()
        if (beside := CASES[name].beside) in ratios and ratios[beside] > 0.0
    }


def _row(figures: Figures) -> dict[str, Any]:
    found = dataclasses.asdict(figures)
    return found | {
        "rate": figures.rate, "timeout_rate": statistics.median(figures.timeouts), "ratio": figures.ratio,
        "decision_ratio": figures.decision_ratio,
    }  # fmt: skip


def _machine() -> dict[str, Any]:
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "system": platform.system(),
        "python": platform.python_version(),
        "simpy": importlib.metadata.version("simpy"),
        "colonysim": colonysim.__version__,
        "compiled": build() == "compiled",
    }


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def save(document: dict[str, Any], path: Path) -> None:
    """Writes a report.

    Raises:
        ColonysimError: It cannot be written.
    """
    replace_file(path, json.dumps(document, indent=1) + "\n")


def stored(path: Path) -> dict[str, Any]:
    """A report that was saved.

    Raises:
        ColonysimError: There is none, or it is of another kind.
    """
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        if document["format"] != FORMAT:
            raise ColonysimError(f"{path}: format {document['format']!r}, expected {FORMAT}")
        for row in document["rows"]:
            if not isinstance(row["case"], str) or not isinstance(row["ratio"], float):
                raise ColonysimError(f"{path}: a row without case and ratio")
    except OSError as error:
        raise ColonysimError(f"{path}: cannot be read: {error.strerror or error}") from error
    except (ValueError, KeyError, TypeError) as error:
        raise ColonysimError(f"{path}: is no report of `colonysim bench`") from error
    kept: dict[str, Any] = document
    return kept


def compared(now: dict[str, Any], before: dict[str, Any]) -> dict[str, float]:
    """How much faster each case has become, by case: 1.1 is a tenth faster.

    Ratios to the yardstick are compared, so that another machine does not count.
    """
    old = {row["case"]: row["ratio"] for row in before["rows"]}
    return {row["case"]: row["ratio"] / old[row["case"]] for row in now["rows"] if old.get(row["case"], 0.0) > 0.0}
