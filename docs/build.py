"""Builds the documentation site into `site/`: `python docs/build.py`, without a network; `--serve` follows changes.

Three pages of the reference are written first, from what the code says of itself: commands, scenario format and trace
tables; then the replay pages of the gallery that are missing. Zensical makes the site from `zensical.toml` and refuses
links that lead nowhere; what it made is searched for anything that a page would load from elsewhere.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
REFERENCE = ROOT / "docs" / "reference"
HEAD = "<!-- Written by docs/build.py. -->\n"
LOADS = re.compile(r"""<(?:script|img|iframe|source|video)\b[^>]*\bsrc=["']?(?:https?:)?//[^"' >]+"""
                   r"""|<link\b(?=[^>]*rel=["']?(?:stylesheet|preload|modulepreload|preconnect|icon))[^>]*"""
                   r"""\bhref=["']?(?:https?:)?//[^"' >]+""")  # fmt: skip


def cell(text: str) -> str:
    """A text as a cell of a table; what stands in backticks is left alone."""
    words = " ".join(text.split()).split("`")
    words[::2] = [each.replace("<", "&lt;").replace("[", "\\[").replace("|", "\\|") for each in words[::2]]
    return "`".join(words)


def commands() -> str:
    """The page of the command line, from the words that `--help` prints."""
    from typer.main import get_command

    from colonysim.cli import app

    top = get_command(app)
    parts = [HEAD, "# Commands\n\n", f"{top.help}\n\n", "What `colonysim COMMAND --help` says, on one page.\n\n"]
    parts.extend(_command(command, name) for name, command in _leaves(top, "colonysim"))
    return "".join(parts)


def _leaves(group: Any, name: str) -> Iterator[tuple[str, Any]]:
    for word, command in group.commands.items():
        if hasattr(command, "commands"):
            yield from _leaves(command, f"{name} {word}")
        else:
            yield f"{name} {word}", command


def _command(command: Any, name: str) -> str:
    context = command.context_class(command, info_name=name)
    usage = " ".join([name, *command.collect_usage_pieces(context)])
    records = [record for each in command.get_params(context) if (record := each.get_help_record(context))]
    rows = [f"| {cell(f'`{option}`')} | {cell(text)} |\n" for option, text in records]
    parts = [f"## {name}\n\n```text\n{usage}\n```\n\n{command.help}\n\n"]
    parts.append("| | |\n|---|---|\n" + "".join(rows) + "\n")
    if command.epilog:
        examples = command.epilog.replace("\b", "").strip().partition("\n")[2]
        shown = "\n".join(f"$ {line.strip()}" for line in examples.splitlines())
        parts.append(f"```console\n{shown}\n```\n\n")
    return "".join(parts)


def scenario_format() -> str:
    """The page of the scenario format, from its JSON Schema."""
    from colonysim.policies.schema import scenario_schema

    schema = scenario_schema()
    parts = [
        HEAD,
        "# Scenario format\n\nEvery field that a scenario file may have, from the JSON Schema that `colonysim schema` "
        "prints. What the fields mean together is told in [Scenarios](../scenarios.md).\n\n",
        "## Scenario\n\n",
        _fields(schema),
    ]
    for name, kind in schema["$defs"].items():
        if "properties" in kind and name != "Variant":
            parts += [f"## {name}\n\n", f"{kind.get('description', '')}\n\n", _fields(kind)]
    return "".join(parts)


def _fields(kind: dict[str, Any]) -> str:
    required = kind.get("required", ())
    rows = ["| field | values | default | |\n|---|---|---|---|\n"]
    for name, field in kind["properties"].items():
        default = "required" if name in required else shown(field.get("default"))
        rows.append(f"| `{name}` | {values(field)} | {default} | {cell(field.get('description', ''))} |\n")
    return "".join(rows) + "\n"


def shown(value: Any) -> str:
    """A default, as it would be written in YAML."""
    if value in (None, "", []) or isinstance(value, dict):
        return ""
    words = {True: "true", False: "false"}[value] if isinstance(value, bool) else value
    return f"`{words:g}`" if isinstance(words, float) else f"`{words}`"


def values(field: dict[str, Any]) -> str:
    """What a field of the schema may be, in words."""
    for several in ("anyOf", "oneOf"):
        if several in field:
            return " or ".join(dict.fromkeys(values(each) for each in field[several] if each.get("type") != "null"))
    if "$ref" in field:
        name = field["$ref"].rpartition("/")[2]
        return _ROWS.get(name, f"[{name}](#{name.lower()})")
    if "enum" in field or "const" in field:
        return " or ".join(f"`{word}`" for word in field.get("enum", [field.get("const")]))
    kind = field.get("type")
    if kind == "array":
        several = field.get("items") or (field.get("prefixItems") or [{}])[0]
        if (count := field.get("minItems")) is not None and count == field.get("maxItems"):
            return f"`[{', '.join(['...'] * count)}]` of {count} values, each {values(several)}"
        return f"list of {values(several)}" if several else "list"
    if kind == "object":
        each = field.get("additionalProperties")
        return f"{values(each)} by name" if isinstance(each, dict) else "mapping"
    if kind in ("number", "integer"):
        word = "number" if kind == "number" else "whole number"
        low, above, high = (field.get(bound) for bound in ("minimum", "exclusiveMinimum", "maximum"))
        bounds = [f"at least {low:g}"] if low is not None else [f"above {above:g}"] if above is not None else []
        bounds += [f"at most {high:g}"] if high is not None else []
        return f"{word}, {' and '.join(bounds)}" if bounds else word
    return {"string": "text", "boolean": "true or false", None: "anything"}.get(kind, str(kind))


_ROWS = {"NodeRow": "`[id, x, y, z]`", "BoxRow": "`[node, height]`", "Duration": "`[from, to, seconds]`",
         "Variant": "any of these fields"}  # fmt: skip
"""What has no section of its own on the page."""


def trace_tables() -> str:
    """The page of the tables of a run."""
    from colonysim.trace import schema

    rows_of = {
        "events": schema.Event, "decisions": schema.Decision, "deposits": schema.Deposit, "frames": schema.Frame,
        "episodes": schema.EpisodeResult, "measurements": schema.Measurement,
    }  # fmt: skip
    parts = [
        HEAD,
        f"# Trace tables\n\nThe tables of a run directory, schema version {schema.VERSION}, as `colonysim schema "
        "trace` prints them; [Runs](../runs.md) says how to read them. Nodes go by their numbers in the scenario file, "
        "boxes and agents by their position in it, holes by the number of their node; -1 stands for none. `ints` and "
        "`floats` are lists.\n\n",
    ]
    for table, columns in schema.TABLES.items():
        parts.append(f"## {table}\n\n")
        text = rows_of[table].__doc__ or "" if table in rows_of else _OF_BODIES[table]
        summary, _, attributes = text.partition("Attributes:")
        meanings = {name: " ".join(said.split())
                    for name, said in re.findall(r"^ +(\w+): (.*(?:\n {12,}.*)*)", attributes, re.M)}  # fmt: skip
        parts.append(" ".join(summary.split()) + "\n\n| column | type | |\n|---|---|---|\n")
        parts.extend(f"| `{name}` | {kind} | {cell(meanings.get(name, ''))} |\n" for name, kind in columns.items())
        parts.append("\n")
    return "".join(parts)


_OF_BODIES = {
    "poses": "Where a body was, ten times a second while it moves; with rigid bodies only.\n\nAttributes:\n"
    '    body: "agent" or "box".\n    number: Which agent or box.\n    x: Metres, and so are y and z.\n'
    "    roll: Radians, and so are pitch and yaw.\n",
    "controls": "A control that was held; with rigid bodies only.\n\nAttributes:\n"
    "    chooser: What chose it: the network or the script.\n    ticks: How many ticks of the backend it was held.\n",
}
"""Tables that are written by backends and have no class of their own."""

PAGES = {"commands.md": commands, "scenario-format.md": scenario_format, "trace-tables.md": trace_tables}


def write_pages() -> None:
    """Writes the generated pages; those that are as they should be are left alone, for `--serve` watches them."""
    for name, make in PAGES.items():
        path, text = REFERENCE / name, make()
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def foreign_loads(site: Path) -> list[str]:
    """What pages of the site would load from elsewhere, as "page: tag"."""
    pages = {page: page.read_text(encoding="utf-8") for page in sorted(site.rglob("*.html"))}
    return [f"{page.relative_to(site)}: {found}" for page, text in pages.items() for found in LOADS.findall(text)]


def main() -> int:
    """Builds the site, or serves it."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else None)
    parser.add_argument("--serve", action="store_true", help="serve the site on this machine and follow changes")
    serve = parser.parse_args().serve
    write_pages()
    sys.path.insert(0, str(ROOT / "docs" / "gallery"))
    from make import make_missing_replays

    make_missing_replays()
    words = ["serve"] if serve else ["build", "--strict", "--clean"]
    code = subprocess.run([sys.executable, "-m", "zensical", *words], cwd=ROOT, check=False).returncode
    if code or serve:
        return code
    loads = foreign_loads(ROOT / "site")
    for line in loads:
        print(f"{line}: is loaded from elsewhere", file=sys.stderr)
    return 1 if loads else 0


if __name__ == "__main__":
    sys.exit(main())
