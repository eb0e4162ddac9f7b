"""What a change of a scenario's timeline does to the world."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from colonysim.scenario.changes import Change
    from colonysim.world.state import World

__all__ = ["make", "possible"]


def possible(world: World, change: Change) -> bool:
    """Whether nobody is in the way of a change."""
    node = change.node
    if change.kind == "add_box":
        return world.occupant[node] == -1 and world.node_holder[node] == -1 and node != world.goal
    if change.kind == "remove_box":
        at = world.box_node[change.box]
        held = at < 0 or world.box_claim[change.box] != -1
        return not held and world.occupant[at] == -1 and world.node_holder[at] == -1
    if change.kind == "add_agent":
        return world.occupant[node] == -1 and world.node_holder[node] == -1 and world.top[node] == -1
    return True


def make(world: World, change: Change) -> int:
    """Lets a change happen that is `possible`; one of agents that fail or of marks does nothing to the world.

    Returns:
        The node concerned, or -1.
    """
    node = change.node
    if change.kind == "add_edge":
        world.terrain.give_edge(node, change.target, world.floor)
    elif change.kind == "remove_edge":
        world.terrain.take_edge(node, change.target)
    elif change.kind == "set_surface":
        world.set_floor(node, change.z)
    elif change.kind == "add_box":
        world.add_box(change.box)
    elif change.kind == "remove_box":
        return world.remove_box(change.box)
    elif change.kind == "move_goal":
        world.move_goal(node)
    elif change.kind == "add_agent":
        world.join(change.agents[0])
    return node
