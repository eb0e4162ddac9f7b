"""`colonysim validate`: check scenario files without running them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from collections.abc import Iterator

    from colonysim.physics import Robot
    from colonysim.policies.policy import Policy
    from colonysim.scenario.scenario import Scenario

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim validate my.yaml
  colonysim validate scenarios/*.yaml
  colonysim validate my.yaml --set policy.beta=2
  colonysim validate my.yaml --backend physics
"""


def command(
    scenarios: Annotated[list[str], typer.Argument(help="Scenario files, or names of scenarios.", show_default=False)],
    variant: Annotated[
        str | None, typer.Option("--variant", "-v", help="Only this variant. [default: all of them]")
    ] = None,
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Set a field first; may be given again.")
    ] = None,
    backend: Annotated[
        str,
        typer.Option("--backend", "-b", help="Check for this backend too: physics, bullet and mujoco build the place."),
    ] = "nodeworld",
) -> None:
    """Check scenario files without running them.

    Each of their variants and the policy's parameters are checked too. No code of others is
    imported: what a run would load is named, and its parameters are left to the run, as
    is the room for a robot of others.

    A fault is told as file:line:column: field: what is wrong; the exit code is then 2.
    """
    from colonysim.cli.console import say
    from colonysim.errors import ColonysimError

    faults = 0
    for name in scenarios:
        try:
            _check(name, variant, settings or [], backend)
        except ColonysimError as error:
            say(f"Error: {error}")
            faults += 1
    if faults:
        raise SystemExit(2)


def _check(name: str, variant: str | None, settings: list[str], backend: str) -> None:
    from colonysim.characters import printable
    from colonysim.cli.console import print_result, say
    from colonysim.geometry.robot_choice import of_others, robot_of, robots_of
    from colonysim.physics import STANDARD
    from colonysim.plugins import BUILT_IN, PHYSICS, locate, refuse_other_engine
    from colonysim.scenario.groups import refuse_speeds
    from colonysim.scenario.loading import load_scenario, load_variants

    body = locate("backends", backend)
    backend = next((named for named, place in BUILT_IN["backends"].items() if place == body), backend)
    one_only = ((variant, load_scenario(name, variant, settings)),) if variant is not None else ()
    for one, scenario in one_only or load_variants(name, settings):
        loaded = [] if backend in BUILT_IN["backends"] else [f"backend {body}"]
        loaded += _check_policies(scenario)
        robots = of_others(scenario)
        models = [STANDARD] if robots else [robot_of(scenario), *robots_of(scenario)]
        loaded += [f"robot {robot}, whose numbers, and the room for it, are not checked here" for robot in robots]
        if backend in PHYSICS:
            from colonysim.backends.changes import refuse_changes
            from colonysim.backends.physics import Physics
            from colonysim.geometry.layout import lay_out

            refuse_other_engine(scenario, None if backend == "physics" else backend)
            refuse_changes(scenario, backend, Physics.changes)
            refuse_speeds(scenario)
            if not robots:
                lay_out(scenario)
        shown = printable(name, len(name))
        label = shown if one is None else f"{shown} (variant {one})"
        print_result(f"{label}: valid: {_outline(scenario)}")
        if loaded:
            print_result(f"{label}: a run imports {'; '.join(loaded)}")
        for warning in _warnings(scenario, models[0]):
            say(f"Warning: {label}: {warning}")


def _check_policies(scenario: Scenario) -> list[str]:
    """Checks the policies of all and of groups, if they are of this package; says what else a run imports for them."""
    from colonysim.plugins import BUILT_IN, locate, make_policy
    from colonysim.scenario.changes import refuse_unknown_marks
    from colonysim.scenario.groups import refuse_unknown_fields
    from colonysim.simulation.groups import located, policy_of_group
    from colonysim.simulation.tuning import check_tunings
    from colonysim.trace.rows import Rows
    from colonysim.world.state import World

    loaded: dict[str, None] = {}
    main: Policy | None = None
    made: list[Policy] = []
    for n in range(-1, len(scenario.groups)):
        asked = scenario if n < 0 else scenario.of_group(n)
        place = located(asked)
        if asked.policy not in BUILT_IN["policies"]:
            loaded[f"policy {place}, whose parameters are not checked here"] = None
            continue
        policy = make_policy(None, asked) if n < 0 or main is None else policy_of_group(scenario, n, main)
        made.append(policy)
        main = policy if n < 0 else main
        for field in asked.parameters.get("extra_fields", ()):
            loaded[f"field {locate('fields', field)}"] = None
    if not loaded and (scenario.groups or scenario.changes):
        world = World(scenario)
        known = [*dict.fromkeys(name for policy in made for name in policy.fields(world))]
        refuse_unknown_fields(scenario, known)
        refuse_unknown_marks(scenario, known)
        check_tunings(scenario, None, world, Rows(scenario, None, decisions=False), known)
    return [*loaded]


def _warnings(scenario: Scenario, robot: Robot) -> Iterator[str]:
    """What is allowed and rarely meant: edges that take longer than an episode waits for anything to happen."""
    from colonysim.geometry.scale import metres_of
    from colonysim.push.driving import TRAVEL_SPEED

    topology, timing = scenario.topology, scenario.timing
    i = max(range(len(topology)), key=lambda node: max(topology.lengths[node], default=0.0))
    if not topology.lengths[i]:
        return
    length = max(topology.lengths[i])
    j = topology.neighbours[i][topology.lengths[i].index(length)]
    metres = length * metres_of(scenario, robot)
    speed = TRAVEL_SPEED * robot.scale / robot.time_unit
    found = [
        (timing.travel_fixed + timing.travel * length, "to travel", (i, j)),
        *((seconds, "to travel", edge) for edge, seconds in timing.travels.items()),
        (metres / speed, f"to drive on a physics backend ({metres:g} m)", (i, j)),
    ]
    if scenario.boxes:
        found.append((timing.push_fixed + timing.push * length, "to push a box over", (i, j)))
        found += [(seconds, "to push a box over", edge) for edge, seconds in timing.pushes.items()]
    slow: dict[str, tuple[float, tuple[int, int]]] = {}
    for seconds, what, edge in found:
        if seconds > max(scenario.stall_seconds, slow.get(what, (0.0, edge))[0]):
            slow[what] = (seconds, edge)
    for what, (seconds, (a, b)) in slow.items():
        yield (
            f"edge {topology.ids[a]}-{topology.ids[b]} takes {seconds:g} s {what}, longer than stall_seconds"
            f" ({scenario.stall_seconds:g}); are coordinates and timing in the units that were meant?"
        )


def _outline(scenario: Scenario) -> str:
    counts = [
        (len(scenario.topology), "node"), (scenario.topology.edge_count, "edge"), (len(scenario.holes), "hole"),
        (len(scenario.boxes), "box"), (len(scenario.agents), "agent"),
    ]  # fmt: skip
    plural = {"box": "boxes"}
    return ", ".join(f"{n} {word if n == 1 else plural.get(word, word + 's')}" for n, word in counts)
