"""docs/equations.md and docs/readings.md name functions, tests and options that exist."""

from __future__ import annotations

import dataclasses
import importlib
import importlib.util
import re
from pathlib import Path

import pytest

from colonysim.policies.settings import StigmergySettings

ROOT = Path(__file__).resolve().parents[2]
DOCS = ("equations.md", "readings.md")


def quoted(name: str) -> list[str]:
    return re.findall(r"`([^`]+)`", (ROOT / "docs" / name).read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", DOCS)
def test_every_test_that_is_named_exists(name):
    named = [text for text in quoted(name) if "::" in text or (text.startswith("tests/") and text.endswith(".py"))]
    assert len(named) > 20
    for text in named:
        file, _, function = text.partition("::")
        file = {"rows": "test_readings_rows.py"}.get(file, file)
        path = ROOT / file if file.startswith("tests/") else ROOT / "tests" / "core" / file
        assert path.is_file(), text
        assert f"def {function}(" in path.read_text(encoding="utf-8") if function else True, text


def source(parts: list[str]) -> Path:
    """The file of a module or of a package."""
    folder = ROOT.joinpath(*parts)
    return folder / "__init__.py" if folder.is_dir() else folder.with_suffix(".py")


def test_every_function_that_is_named_exists():
    named = [text for text in quoted("equations.md") if text.startswith("colonysim.")]
    assert len(named) > 25
    for text in named:
        parts = text.split(".")
        depth = max(n for n in range(1, len(parts) + 1) if source(parts[:n]).is_file())
        module = source(parts[:depth])
        if ".push." in text:  # its optional parts need not be installed here
            assert re.search(rf"^(class|def) {parts[depth]}\b", module.read_text(encoding="utf-8"), re.M), text
            continue
        found = importlib.import_module(".".join(parts[:depth]))
        for part in parts[depth:]:
            found = getattr(found, part)


def test_every_option_has_its_row():
    said = " ".join(quoted("readings.md"))
    for field in dataclasses.fields(StigmergySettings):
        assert field.name in said or field.name in ("extra_fields", "weights"), field.name
