"""One HTML file that needs nothing else: style, program and data are put into the page itself."""

from __future__ import annotations

import base64
import hashlib
import re
from importlib.resources import files
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from colonysim.view.packing import Block

__all__ = ["LIVE", "MODULES", "STILL", "page"]

#: In this order no module uses one that comes later.
MODULES = (
    "palette", "unpack", "shapes", "replay", "camera", "marks", "land", "heat", "ground", "far", "things", "map",
    "matrices", "solids", "scene", "charts", "panels", "keys", "main",
)  # fmt: skip
#: What follows them in a page that holds its run, and in one that follows a run under way.
STILL, LIVE = ("still",), ("growth", "teacher", "live")
_IMPORT = re.compile(r"^import\b[^;]*;\n", re.MULTILINE)
_EXPORT = re.compile(r"^export (?=const|let|class|function|async)", re.MULTILINE)


def page(block: Block, live: bool = False) -> str:
    """The page of a packed run.

    Its Content-Security-Policy admits this style and this program by their hashes, and no connection at all. The
    data are base64 within a script element of a type that nothing executes, so no text of a run is ever markup.

    Args:
        block: The run.
        live: Whether the run is under way: the page then asks the server that it came from, and nobody else, for
            what happens.
    """
    style = _asset("page.css") + (_asset("teacher.css") if live else "")
    modules = MODULES + (LIVE if live else STILL)
    program = "\n".join(_EXPORT.sub("", _IMPORT.sub("", _asset(f"{name}.js"))) for name in modules)
    connections = "; connect-src 'self'" if live else ""
    policy = (
        f"default-src 'none'; script-src '{_digest(program)}'; style-src '{_digest(style)}'; "
        f"base-uri 'none'; form-action 'none'{connections}"
    )
    parts = {
        "policy": policy,
        "style": style,
        "program": program,
        "data": base64.b64encode(block.compressed()).decode(),
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda found: parts[found[1]], _asset("page.html"))


def _asset(name: str) -> str:
    return files("colonysim.view").joinpath("assets", name).read_text(encoding="utf-8")


def _digest(text: str) -> str:
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"
