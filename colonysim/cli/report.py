"""`colonysim report`: what failed in a run, where, when and why, and which agents did not reach the goal."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from colonysim.files import shown_path

if TYPE_CHECKING:
    from colonysim.trace.failures import Attempts, Grouping
    from colonysim.trace.groups import GroupResult
    from colonysim.trace.reader import Run
    from colonysim.trace.schema import Event
    from colonysim.trace.stranded import Stranded

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim report runs/hard-bullet-s0-1
  colonysim report runs/hard-bullet-s0-1 --by edge --episodes 11-20
  colonysim report runs/hard-bullet-s0-1 --json
"""


def command(
    path: Annotated[Path, typer.Argument(metavar="RUN", help="A run directory.", show_default=False)],
    by: Annotated[
        Literal["reason", "edge", "agent", "group"],
        typer.Option("--by", help="Count failures by reason, edge, agent or group of agents."),
    ] = "reason",
    episodes: Annotated[
        str | None, typer.Option("--episodes", help="Only these, such as 1,3,10 or 1-5.", show_default="all")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the report as one JSON object.")] = False,
) -> None:
    """List the failed pushes and travels of a run, and the agents that did not reach the goal.

    Failures are counted, then named one by one with time and place. A take is the first step of a push, onto
    the box's node. The share is that of the failures among all attempts of the same action (by edge or
    agent: of the same action there), with its 95 % interval (Wilson). For each agent that was not at the goal
    at the end of an episode stands where it was and what it did last: an agent can use up its steps on two nodes
    without a failure. Success and steps are told for each group of agents, if the scenario has any. Runs that were
    interrupted, or are still under way, can be reported too.
    """
    from colonysim.cli.console import print_json
    from colonysim.cli.numbers import read_numbers
    from colonysim.cli.opening import opened
    from colonysim.cli.summary import print_groups
    from colonysim.errors import ColonysimError
    from colonysim.trace.failures import attempts
    from colonysim.trace.groups import results_of_groups
    from colonysim.trace.stranded import stranded

    run = opened(path)
    chosen = None if episodes is None else read_numbers(episodes)
    found, short = attempts(run, chosen), stranded(run, chosen)
    if by == "group" and not found.group_of:
        raise ColonysimError(f"--by group: {path} has no groups of agents; expected reason, edge or agent")
    groups = results_of_groups(run, chosen)
    if as_json:
        print_json(_as_json(run, found, by, short, groups))
    else:
        _print(run, found, by)
        print_groups(groups)
        _print_stranded(short)


def _as_json(
    run: Run, found: Attempts, by: Grouping, short: list[Stranded], groups: list[GroupResult]
) -> dict[str, Any]:
    """Nodes, boxes and holes by their numbers in the scenario's file; null for none."""
    from colonysim.cli.summary import by_group

    manifest = run.manifest
    return {
        "run": None if run.path is None else shown_path(run.path),
        "scenario": manifest["name"],
        "backend": manifest["backend"],
        "policy": manifest["policy"],
        "seed": manifest["seed"],
        "status": run.status,
        "episodes": list(found.episodes),
        "attempts": found.counts,
        **({"groups": by_group(groups)} if groups else {}),
        "by": by,
        "summary": [
            {
                "action": tally.action,
                by: int(tally.group) if by == "agent" else tally.group,
                "count": tally.count,
                "attempts": tally.attempts,
                "share": tally.share,
                "low": tally.interval[0],
                "high": tally.interval[1],
                "reasons": tally.reasons,
                "first": _row(found, tally.first),
            }
            for tally in found.tally(by)
        ],
        "failures": [_row(found, event) for event in found.failures],
        "stranded": [
            {
                "episode": agent.episode,
                "agent": agent.agent,
                "ended": agent.ended,
                "state": agent.state,
                "node": _known(agent.node),
                "waits_for": _known(agent.waits_for),
                "since": agent.since,
                "until": agent.until,
                "nodes": list(agent.nodes),
                "attempts": agent.attempts,
                "failures": agent.failures,
                "waited": agent.waited,
                "way_open": agent.way_open,
                "why": agent.why,
            }
            for agent in short
        ],
    }


def _known(number: int) -> int | None:
    return None if number < 0 else number


def _row(found: Attempts, event: Event) -> dict[str, Any]:
    return {
        "episode": event.episode,
        "time": event.time,
        "agent": event.agent,
        "action": event.action,
        "from": _known(event.node),
        "to": _known(event.target),
        "place": found.place(event),
        "box": _known(event.box),
        "hole": _known(event.hole),
        "status": event.status,
        "reason": event.reason,
    }


def _print(run: Run, found: Attempts, by: Grouping) -> None:
    from colonysim.cli.console import print_result, print_table

    manifest, counts, episodes = run.manifest, found.counts, len(found.episodes)
    tried = ", ".join(f"{action} {count}" for action, count in counts.items())
    unfinished = f" · {run.shortfall}" if run.shortfall else ""
    print_result(
        f"{manifest['name']} · {manifest['backend']} · {manifest['policy']} · seed {manifest['seed']}{unfinished}: "
        f"{len(found.failures)} of {sum(counts.values())} attempts failed in "
        f"{episodes} {'episode' if episodes == 1 else 'episodes'} ({tried})"
    )
    if not found.failures:
        return
    rows = []
    for tally in found.tally(by):
        low, high = tally.interval
        first, reasons = tally.first, ", ".join(f"{reason} {count}" for reason, count in tally.reasons.items())
        rows.append(
            (
                tally.action,
                tally.group,
                f"{tally.count} of {tally.attempts}",
                f"{tally.share:.4f}",
                f"{low:.4f} to {high:.4f}",
                f"episode {first.episode}, {first.time:.1f} s, {found.place(first)}",
                *([] if by == "reason" else [reasons]),
            )
        )
    more = () if by == "reason" else ("reasons",)
    print_table(("action", by, ">count", ">share", ">95 % interval", "first", *more), rows)
    columns = (">episode", ">time", ">agent", "action", "from-to", ">box", ">hole", "status", "reason")
    print_table(columns, [_line(found, event) for event in found.failures])


def _print_stranded(short: list[Stranded]) -> None:
    from colonysim.cli.console import print_result, print_table

    if not short:
        return
    print_result(f"{len(short)} {'agent' if len(short) == 1 else 'agents'} not at the goal when the episode ended:")
    rows = [(str(agent.episode), str(agent.agent), agent.ended, agent.why) for agent in short]
    print_table((">episode", ">agent", "ended", "why"), rows)


def _line(found: Attempts, event: Event) -> tuple[str, ...]:
    box, hole = ("-" if number < 0 else str(number) for number in (event.box, event.hole))
    return (
        str(event.episode), f"{event.time:.1f}", str(event.agent), event.action, found.place(event), box, hole,
        event.status, event.reason,
    )  # fmt: skip
