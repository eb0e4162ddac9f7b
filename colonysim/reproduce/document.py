"""A report as a list of blocks, written as Markdown and as one HTML file that needs no other."""

from __future__ import annotations

import base64
import html
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from colonysim.errors import ColonysimError
from colonysim.reproduce.judging import WORDS

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["Block", "Heading", "Page", "Picture", "Table", "Text", "as_html", "as_markdown"]


@dataclass(frozen=True)
class Heading:
    """A title; level 1 is the report's."""

    level: int
    text: str


@dataclass(frozen=True)
class Text:
    """A paragraph, or lines that begin with "- ".

    `code`, *words*, **words** and [links](page.md) to other pages are marked as in Markdown.
    """

    text: str


@dataclass(frozen=True)
class Table:
    """Rows of text below names of columns."""

    columns: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True)
class Picture:
    """An image, relative to the report's folder, with what it shows."""

    path: str
    shows: str


Block = Heading | Text | Table | Picture


@dataclass(frozen=True)
class Page:
    """A part of the report.

    Attributes:
        name: Of its file, without ending.
        blocks: What stands there; the first is its title.
    """

    name: str
    blocks: Sequence[Block]


_STYLE = """\
body { font: 15px/1.5 system-ui, sans-serif; color: #222; max-width: 76rem; margin: 2rem auto; padding: 0 1rem; }
table { border-collapse: collapse; margin: 1rem 0; font-size: 13px; }
th, td { border-bottom: 1px solid #ddd; padding: .3rem .6rem; text-align: left; vertical-align: top; }
th { border-bottom: 2px solid #888; }
img { max-width: 100%; }
code { background: #f2f2f2; padding: 0 .2em; }
.agrees, .better { color: #00694c; font-weight: 600; }
.disagrees { color: #a80000; font-weight: 600; }
.undecided { color: #6b5900; font-weight: 600; }
@media (prefers-color-scheme: dark) {
  body { background: #181818; color: #ddd; }
  code { background: #2a2a2a; }
  img { background: #fff; }
  .agrees, .better { color: #4fd0a5; } .disagrees { color: #ff8a80; } .undecided { color: #e6cf5c; }
}
"""


def as_markdown(blocks: Sequence[Block]) -> str:
    """The report as Markdown."""
    parts = []
    for block in blocks:
        if isinstance(block, Heading):
            parts.append(f"{'#' * block.level} {block.text}")
        elif isinstance(block, Text):
            parts.append(block.text.strip())
        elif isinstance(block, Picture):
            parts.append(f"![{block.shows}]({block.path})")
        else:
            lines = [block.columns, ["---"] * len(block.columns), *block.rows]
            parts.append("\n".join(f"| {' | '.join(cell.replace('|', '&#124;') for cell in row)} |" for row in lines))
    return "\n\n".join(parts) + "\n"


def as_html(pages: Sequence[Page], folder: Path) -> str:
    """All pages as one HTML file, images of `folder` inside it.

    Raises:
        ColonysimError: An image cannot be read.
    """
    title = next((block.text for page in pages for block in page.blocks if isinstance(block, Heading)), "Report")
    body = "\n".join(
        f'<section id="{page.name}">\n' + "\n".join(_html(block, folder) for block in page.blocks) + "\n</section>"
        for page in pages
    )
    return (
        f'<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<title>{html.escape(title)}</title>\n'
        f'<meta name="viewport" content="width=device-width">\n<style>\n{_STYLE}</style>\n</head>\n<body>\n{body}\n'
        "</body>\n</html>\n"
    )


def _html(block: Block, folder: Path) -> str:
    if isinstance(block, Heading):
        return f"<h{block.level}>{_inline(block.text)}</h{block.level}>"
    if isinstance(block, Text):
        return "\n".join(_paragraph(part) for part in block.text.strip().split("\n\n"))
    if isinstance(block, Picture):
        try:
            data = base64.b64encode((folder / block.path).read_bytes()).decode()
        except OSError as error:
            raise ColonysimError(f"{folder / block.path}: cannot be read: {error.strerror or error}") from error
        return f'<p><img alt="{html.escape(block.shows)}" src="data:image/png;base64,{data}"></p>'
    head = "".join(f"<th>{_inline(name)}</th>" for name in block.columns)
    rows = "\n".join(f"<tr>{''.join(_cell(cell) for cell in row)}</tr>" for row in block.rows)
    return f"<table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}\n</tbody>\n</table>"


def _cell(text: str) -> str:
    word = re.split(r"[ ,:]", text, maxsplit=1)[0]
    mark = f' class="{word}"' if word in WORDS else ""
    return f"<td{mark}>{_inline(text)}</td>"


def _paragraph(text: str) -> str:
    if not text.startswith("- "):
        return f"<p>{_inline(text)}</p>"
    items = "\n".join(f"<li>{_inline(item)}</li>" for item in text.removeprefix("- ").split("\n- "))
    return f"<ul>\n{items}\n</ul>"


def _inline(text: str) -> str:
    text = html.escape(text, quote=False)
    text = re.sub(r"`([^`]+)`", r"<code>\1</code>", text)
    text = re.sub(r"\[([^\]]+)\]\(([a-z-]+)\.md\)", r'<a href="#\2">\1</a>', text)
    text = re.sub(r"\*\*([^*]+)\*\*", r"<strong>\1</strong>", text)
    return re.sub(r"\*([^*]+)\*", r"<em>\1</em>", text)
