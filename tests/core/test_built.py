"""What the package says of how it was built."""

from __future__ import annotations

import json

import pytest

from colonysim import built


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package of two modules, both compiled."""
    for name in ("one", "two"):
        (tmp_path / f"{name}.py").write_text(f"x = '{name}'\n")
        (tmp_path / f"{name}{built.EXTENSION_SUFFIXES[0]}").write_bytes(b"")
    record = {name: built.digest(tmp_path / name) for name in ("one", "two")}
    (tmp_path / built.RECORD).write_text(json.dumps(record))
    monkeypatch.setattr(built, "PACKAGE", tmp_path)
    built.build.cache_clear()
    yield tmp_path
    built.build.cache_clear()


def test_compiled_in_part_or_not_at_all(package):
    assert built.build() == "compiled"
    built.build.cache_clear()
    (package / f"two{built.EXTENSION_SUFFIXES[0]}").unlink()
    assert built.build() == "1 of 2 modules compiled"
    built.build.cache_clear()
    (package / built.RECORD).unlink()
    assert built.build() == "plain Python"


def test_a_source_that_has_changed_since_is_named(package):
    (package / "two.pxd").write_text("cdef int x\n")
    with pytest.warns(UserWarning, match="^two: the source has changed since it was compiled"):
        assert built.build() == "compiled"


def test_a_compiler_that_failed_is_told(package):
    (package / built.RECORD).write_text(json.dumps({"failed": "command 'cc' failed"}))
    assert built.build() == "plain Python, for compiling failed: command 'cc' failed"


def test_a_record_that_is_none_is_no_error(package):
    for text in ("", "[]", "{", "3"):
        (package / built.RECORD).write_text(text)
        built.build.cache_clear()
        assert built.build() == "plain Python"
