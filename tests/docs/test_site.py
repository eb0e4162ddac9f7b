"""The documentation site builds without a warning, has every page, and loads nothing from elsewhere."""

from __future__ import annotations

import importlib
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType, ModuleType

import pytest

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"


def _module(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


build = _module(DOCS / "build.py")


def _built(folder: Path, pages: Mapping[str, str] = MappingProxyType({})) -> subprocess.CompletedProcess[str]:
    """Builds the site of a copy of the docs in which some pages are others."""
    pytest.importorskip("zensical")
    pytest.importorskip("mkdocstrings")
    shutil.copytree(DOCS, folder / "docs", ignore=shutil.ignore_patterns("__pycache__"))
    for picture in (folder / "docs" / "gallery").glob("*.png"):
        picture.with_suffix(".html").write_text("<title>a replay</title>", "utf-8")  # or it would be made
    for name, text in pages.items():
        (folder / "docs" / name).write_text(text, "utf-8")
    shutil.copy(ROOT / "zensical.toml", folder)
    (folder / "colonysim").symlink_to(ROOT / "colonysim")
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "NO_COLOR": "1"}
    return subprocess.run(
        [sys.executable, "docs/build.py"], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


def test_the_site_builds_without_a_warning(tmp_path: Path) -> None:
    done = _built(tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "warning" not in (done.stdout + done.stderr).lower()
    site = tmp_path / "site"
    pages = {page.relative_to(tmp_path / "docs").with_suffix(".html") for page in (tmp_path / "docs").rglob("*.md")}
    assert pages <= {page.relative_to(site) for page in site.rglob("*.html")}
    assert not [*site.rglob("*.py"), *site.rglob("*.jsonl")]
    # What the code says of itself has come in.
    told = (site / "reference" / "colonysim.html").read_text(encoding="utf-8")
    assert 'id="colonysim.Colony.run_until"' in told and "Loads and validates a scenario." in told
    # The same site with a script from elsewhere is found out.
    page = site / "view.html"
    page.write_text(page.read_text(encoding="utf-8") + '<script src="https://example.org/a.js"></script>', "utf-8")
    assert build.foreign_loads(site) == ['view.html: <script src="https://example.org/a.js']


def test_a_link_that_leads_nowhere_stops_the_build(tmp_path: Path) -> None:
    reference = {f"reference/{page.name}": "# Left out\n" for page in (DOCS / "reference").glob("*.md")}
    faulty = {"view.md": "# View\n\n[one](runs.md#no-such-heading)\n", "speed.md": "# Speed\n\n[one](no-such.md)\n"}
    done = _built(tmp_path, {**reference, **faulty})
    said = done.stdout + done.stderr
    assert done.returncode == 1, said
    assert "view.md:3" in said and "speed.md:3" in said


def test_every_page_is_in_the_navigation_once() -> None:
    def pages(part: object) -> list[str]:
        if isinstance(part, str):
            return [part]
        return [page for each in (part.values() if isinstance(part, dict) else part) for page in pages(each)]  # type: ignore[attr-defined]

    listed = pages(tomllib.loads((ROOT / "zensical.toml").read_text("utf-8"))["project"]["nav"])
    there = {page.relative_to(DOCS).as_posix() for page in DOCS.rglob("*.md")}
    there |= {f"reference/{name}" for name in build.PAGES}
    assert sorted(listed) == sorted(there)


def test_the_page_of_commands_has_all_of_them_with_all_their_options() -> None:
    from typer.main import get_command

    from colonysim.cli import app

    page = build.commands()
    for name, command in build._leaves(get_command(app), "colonysim"):
        section = page.split(f"\n## {name}\n")[1].split("\n## ")[0]
        context = command.context_class(command, info_name=name)
        for parameter in (each for each in command.params if each.get_help_record(context)):
            for option in (each for each in (*parameter.opts, *parameter.secondary_opts) if each[0] == "-"):
                assert re.search(rf"{re.escape(option)}\b", section), (name, option)


def test_the_page_of_the_format_has_every_field_and_says_what_it_may_be() -> None:
    from colonysim.policies.schema import scenario_schema

    page, schema = build.scenario_format(), scenario_schema()
    for name, kind in [("Scenario", schema), *schema["$defs"].items()]:
        if "properties" not in kind or name == "Variant":
            continue
        section = page.split(f"\n## {name}\n")[1].split("\n## ")[0]
        assert re.findall(r"^\| `(\w+)` \|", section, re.M) == [*kind["properties"]]
        assert "None" not in section and "{'" not in section
    assert "| `reach` | number, at least 1e-06 and at most 1e+09 | `0.3` |" in page
    assert "| `mode` | `asynchronous` or `synchronous` | `asynchronous` |" in page


def test_the_page_of_the_tables_has_every_column() -> None:
    from colonysim.trace.schema import TABLES

    page = build.trace_tables()
    for table, columns in TABLES.items():
        section = page.split(f"\n## {table}\n")[1].split("\n## ")[0]
        assert re.findall(r"^\| `(\w+)` \| (\w+) \|", section, re.M) == [*columns.items()]


@pytest.mark.parametrize("name", ["", "policies", "rl", "testing", "sweep"])
def test_the_reference_has_every_public_name(name: str) -> None:
    if name == "rl":
        pytest.importorskip("pettingzoo")
    module = importlib.import_module(f"colonysim.{name}".rstrip("."))
    page = (DOCS / "reference" / f"{name or 'colonysim'}.md").read_text("utf-8")
    told = set(re.findall(r"^::: colonysim(?:\.\w+)*\.(\w+)$", page, re.M))
    for members in re.findall(r"members: \[(.*)\]", page):
        told |= {member.strip() for member in members.split(",")}
    assert {each for each in module.__all__ if not each.startswith("__") and each != "REWARDS"} <= told
