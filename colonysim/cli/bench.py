"""`colonysim bench`: how fast colonies run on this machine."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim bench
  colonysim bench hard boxes-1000 --rounds 3
  colonysim bench --save before.json     (change something)
  colonysim bench --compare before.json
"""


def command(
    cases: Annotated[
        list[str] | None, typer.Argument(help="Cases; see --list. [default: the common ones]", show_default=False)
    ] = None,
    rounds: Annotated[int, typer.Option("--rounds", "-n", min=1, help="Rounds; medians are shown.")] = 5,
    save_to: Annotated[Path | None, typer.Option("--save", metavar="FILE", help="Keep the figures.")] = None,
    compare: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Show how much faster each case is than in a kept file.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON.")] = False,
    list_cases: Annotated[bool, typer.Option("--list", help="Say which cases there are.")] = False,
) -> None:
    """Time colonies of many sizes beside bare SimPy timeouts.

    The ratio is steps a second over bare timeouts a second with as many processes, taken in turn: it says
    more than either of them on a machine that does other things too. "decided" counts waits as well as steps, and
    "of built in" sets a case in which a user brings something beside the case on the same world in which nobody does.
    """
    from colonysim.bench import CASES, compared, measure, report, save, shares, stored
    from colonysim.cli.console import print_json, print_table, say
    from colonysim.errors import ColonysimError
    from colonysim.files import check_writable
    from colonysim.suggest import nearest

    if list_cases:
        if cases or save_to is not None or compare is not None or as_json:
            raise ColonysimError("--list stands alone: nothing is timed")
        print_table(["case", "what runs"], [[case.name, case.about] for case in CASES.values()])
        return
    for name in cases or ():
        if name not in CASES:
            raise ColonysimError(f"no case {name!r}; {nearest(name, CASES)}")
    before = stored(compare) if compare is not None else None
    if save_to is not None:
        check_writable(save_to)
    figures = []
    for name in cases or [case.name for case in CASES.values() if case.common]:
        say(f"{name}: {CASES[name].about}")
        figures.append(measure(name, rounds))
    document = report(figures)
    if save_to is not None:
        save(document, save_to)
    faster = compared(document, before) if before is not None else {}
    if as_json:
        print_json(document | {"faster": faster} if before is not None else document)
        return
    columns = [
        "case", ">agents", ">steps", ">steps/s", ">timeouts/s", ">ratio", ">decided", ">of built in", ">build s",
        ">peak MB",
    ]  # fmt: skip
    if before is not None:
        columns.append(">against before")
    machine = document["machine"]
    about = f"{machine['processor']}, Python {machine['python']}, SimPy {machine['simpy']}"
    kind = "compiled" if machine["compiled"] else "not compiled"
    title = f"medians of {rounds} rounds; {about}; colonysim {machine['colonysim']}, {kind}"
    beside = shares(figures)
    print_table(columns, [_cells(row, beside, faster, before is not None) for row in document["rows"]], title)


def _cells(
    row: Mapping[str, Any], beside: Mapping[str, float], faster: Mapping[str, float], against: bool
) -> list[str]:
    name, peak = row["case"], "-" if row["peak_mb"] is None else f"{row['peak_mb']:.0f}"
    cells = [
        name, f"{row['agents']:,}", f"{row['steps']:,}", f"{row['rate']:,.0f}", f"{row['timeout_rate']:,.0f}",
        f"{row['ratio']:.3f}", f"{row['decision_ratio']:.3f}", f"{beside[name]:.3f}" if name in beside else "",
        f"{row['build_seconds']:.2f}", peak,
    ]  # fmt: skip
    if against:
        cells.append(f"{faster[name]:.2f}" if name in faster else "new")
    return cells
