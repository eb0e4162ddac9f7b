"""`colonysim policies`: what can decide for the agents, and which parameters it has."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from collections.abc import Sequence

    from colonysim.policies.described import DescribedPolicy
    from colonysim.policies.parameters import Parameter

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim policies
  colonysim policies paper
  colonysim policies my_package.my_module:MyPolicy
  colonysim policies --markdown > docs/policies.md
"""


def command(
    name: Annotated[
        str | None, typer.Argument(help="Print this policy's parameters.", show_default=False)
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    as_markdown: Annotated[bool, typer.Option("--markdown", help="Print Markdown, as in docs/policies.md.")] = False,
) -> None:
    """List policies, or print the parameters of one: type, values, default, meaning, and where the paper has it.

    Parameters stand in a scenario's `policy:` section, or are set by --set policy.NAME=VALUE.
    The list imports no code of others; a policy that is asked for by its name is imported.
    """
    from colonysim.cli.console import print_json, print_result, print_table, print_text
    from colonysim.errors import ColonysimError
    from colonysim.policies.described import describe, list_policies

    if as_json and as_markdown:
        raise ColonysimError("--json and --markdown: expected one of them")
    listed = [*list_policies()] if name is None else [describe(name)]
    if as_json:
        found = [_plain(policy) for policy in listed]
        print_json(found if name is None else found[0])
    elif as_markdown:
        print_text(_page() if name is None else _section(listed))
    elif name is None:
        print_table(("policy", "parameters", ""), [(each.name, _count(each), _told(each)) for each in listed])
    else:
        [policy] = listed
        print_result(f"{policy.name} ({policy.place}): {policy.summary or 'it has no docstring'}")
        if not policy.parameters:
            print_result(_UNTOLD if policy.parameters is None else "It has no parameters.")
            return
        rows = [
            (each.name, each.kind, each.values, _default(each), each.meaning, each.paper) for each in policy.parameters
        ]
        print_table(("parameter", "type", "values", "default", "meaning", "paper"), rows)


_UNTOLD = (
    "It does not say which parameters it has: its class would name a pydantic model of them in its attribute"
    " `parameters`."
)


def _count(policy: DescribedPolicy) -> str:
    return "" if policy.parameters is None else str(len(policy.parameters))


def _told(policy: DescribedPolicy) -> str:
    if policy.imported:
        return policy.summary
    return f"installed as {policy.place}, not imported: `colonysim policies {policy.name}` does, and shows what it says"


def _plain(policy: DescribedPolicy) -> dict[str, Any]:
    parameters = None if policy.parameters is None else [_plain_parameter(each) for each in policy.parameters]
    return {"name": policy.name, "place": policy.place, "summary": policy.summary, "imported": policy.imported,
            "parameters": parameters}  # fmt: skip


def _plain_parameter(parameter: Parameter) -> dict[str, Any]:
    return {
        "name": parameter.name, "type": parameter.kind, "schema": dict(parameter.schema),
        "default": parameter.default, "required": parameter.required, "meaning": parameter.meaning,
        "paper": parameter.paper,
    }  # fmt: skip


_INTRODUCTION = """\
# Policies and their parameters

<!-- Written by `colonysim policies --markdown`; the text stands in colonysim/policies/settings.py. -->

A policy's parameters stand in a scenario's [`policy:` section](scenarios.md#policy), or are set by
`--set policy.NAME=VALUE`. `colonysim policies` lists the policies, `colonysim policies NAME` prints the parameters of
one, also of [your own](extending.md#parameters-of-its-own), and with the JSON Schema of scenario files an editor
completes and explains them.
"""


_OF_STIGMERGY = """
## Parameters of the stigmergic policies

`colony`, `paper` and `oracle` are presets of one policy; `stigmergy` is `colony`, or what its further parameter
`preset` says. The column *source* names the algorithm or section of the paper that has a parameter
([equations](equations.md)). [How the paper is read](readings.md) says why `colony` differs from `paper`.
"""


def _page() -> str:
    """docs/policies.md: this package's policies, and the parameters of those that have some."""
    from colonysim.plugins import BUILT_IN
    from colonysim.policies.described import describe
    from colonysim.policies.settings import PRESETS

    ours = [describe(name) for name in BUILT_IN["policies"]]
    rows = [f"| `{each.name}` | {_marked(each.summary)} |" for each in ours]
    listed = "\n".join(["| policy | |", "|---|---|", *rows])
    presets = [each for each in ours if each.name in PRESETS]
    return f"{_INTRODUCTION}\n{listed}\n{_OF_STIGMERGY}\n{_section(presets)}"


def _section(policies: Sequence[DescribedPolicy]) -> str:
    """A table of the parameters that some policies have in common, each with its defaults."""
    columns = [{each.name: _default(each) for each in policy.parameters or ()} for policy in policies]
    head = ["parameter", "values", *(f"`{policy.name}`" for policy in policies), "source", ""]
    rows = [head, ["---"] * len(head)]
    for each in policies[0].parameters or ():
        first, *others = (column[each.name] for column in columns)
        defaults = [first, *("same" if other == first else other for other in others)]
        words = [*(() if "enum" in each.schema else (each.kind,)), *((each.values,) if each.values else ())]
        rows.append([f"`{each.name}`", _marked(", ".join(words)), *defaults, each.paper, _marked(each.meaning)])
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


def _default(parameter: Parameter) -> str:
    from colonysim.policies.parameters import shown

    return "required" if parameter.required else shown(parameter.default)


def _marked(text: str) -> str:
    """Quoted words as code, and nothing that would end a table's cell."""
    return re.sub(r'"([\w.:]+)"', r"`\1`", " ".join(text.split())).replace("|", "\\|")
