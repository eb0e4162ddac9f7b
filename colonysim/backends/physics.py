# cython: auto_pickle=False
"""Rigid bodies: robots that drive and push in a physics engine, all on one clock."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING

from colonysim.backends.action import Action, Actions
from colonysim.backends.changes import ANYWHERE
from colonysim.backends.executors import executor_called
from colonysim.backends.protocol import Done, Finished, TraceRow
from colonysim.backends.traffic import Traffic
from colonysim.errors import ColonysimError, MissingExtraError
from colonysim.geometry.layout import lay_out
from colonysim.physics import (
    ENGINES,
    TICK_SECONDS,
    MissingEngineError,
    Scene,
    default_engine,
    display_trouble,
    engine_facts,
    window_trouble,
)
from colonysim.plugins import locate
from colonysim.push.driving import TRAVEL_SPEED, drive_to
from colonysim.push.feasibility import load_feasibility
from colonysim.push.gated import chance_of_push
from colonysim.push.paths import Surroundings, everything_else
from colonysim.push.staging import plan_push, staging_points
from colonysim.push.task import PushTask, ignore
from colonysim.push.way import chances_along, load_way_chance
from colonysim.suggest import nearest
from colonysim.world.intents import BoxPlace, Outcome, Push, Travel
from colonysim.world.state import AgentStatus

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from colonysim.backends.protocol import FeasibleWay
    from colonysim.physics import Pose
    from colonysim.push.executors import Executor
    from colonysim.push.task import Kind, Log, Manoeuvre, ManoeuvreResult
    from colonysim.randomness import Streams
    from colonysim.scenario.changes import Change
    from colonysim.scenario.scenario import Scenario
    from colonysim.world.intents import Intent
    from colonysim.world.state import Place, World

__all__ = ["Physics"]

POSE_SECONDS = 0.1
"""Poses of movers are recorded as often as this, as nearly as whole ticks allow."""
APPROACH = 1.55
"""Who takes hold of a box drives up to this distance from its centre: near, and out of contact."""
TURN_TIME = 1.2
"""Rough time of turning towards the next node, part of a typical edge's time."""
ARRIVAL = 0.08
FEASIBILITIES = ("geometry", "forest", "way")
SUITED = {"staged": "way", "rl": "forest", "scripted": "geometry"}
"""What foresees the success of an executor's pushes, unless another estimate is asked for."""
FAULTS = frozenset({"flipped", "in_pit", "fallen", "nan"})
_make = tuple.__new__


class Physics:
    """Drives robots as rigid bodies; a push is carried out by an executor.

    Args:
        push: "staged" (a script drives behind the box, the network does the rest), "rl" (the network from where
            the feasibility classifier expects it to succeed), "scripted" (no learning), or one of others: the name
            under which it is installed, or "package.module:Name".
        model: Another network than the shipped one: the path of its card, or an ONNX file.
        feasibility: What says whether a push is tried: "geometry" (the planner's yes or no), "forest" (the paper's
            classifier), or "way" (a calibrated chance, also of the pushes after the next). None is what suits the
            executor: "way" for "staged", to which it was fitted, "forest" for "rl", "geometry" for all others.
        engine: "bullet" or "mujoco"; by default the first of them that is installed.
        gui: Whether to open the engine's window (Bullet only).

    Attributes:
        name: Name of the engine.
        engine: Name, version and settings of the engine, for the manifest.
        recording: Whether poses and controls are kept for `rows`.

    Raises:
        MissingExtraError: The engine is not installed.
        ColonysimError: There is no such executor (the nearest is named), estimate or engine, the model cannot be used,
            or there is no display for the window.
    """

    tick: float | None
    changes = (*ANYWHERE, "add_box", "remove_box", "add_agent")
    replayable = True
    """An episode that is gone through again comes to the same; the manoeuvres under way cannot be written down."""

    def __init__(
        self,
        push: str = "staged",
        model: str | None = None,
        feasibility: str | None = None,
        engine: str | None = None,
        gui: bool = False,
    ) -> None:
        self.push = str(push)
        locate("executors", self.push)
        self.tick = TICK_SECONDS
        self.edge_seconds = 1.0
        self.recording = True
        self._gui = gui
        engine = default_engine() if engine is None else engine
        try:
            self.engine = engine_facts(engine)
        except MissingEngineError as error:
            raise MissingExtraError(str(error)) from None
        except ValueError:
            raise ColonysimError(f"no engine {engine!r}; {nearest(str(engine), ENGINES)}") from None
        if gui:
            _check_window(engine)
        # The classifier was fitted to pushes of the executor `rl`: no other uses it unless asked to.
        self.feasibility = feasibility or SUITED.get(self.push, "geometry")
        if self.feasibility not in FEASIBILITIES:
            raise ColonysimError(f"no feasibility {feasibility!r}; {nearest(str(self.feasibility), FEASIBILITIES)}")
        gate = load_feasibility() if self.push == "rl" else None
        self._execute: Executor = executor_called(self.push, model=model, gate=gate)
        self._forest = (gate or load_feasibility()) if self.feasibility == "forest" else None
        self._way_chance = load_way_chance() if self.feasibility == "way" else None
        self._scene: Scene | None = None
        self._laid_out: Scenario | None = None

    @property
    def name(self) -> str:
        """Name of the engine."""
        name: str = self.engine.name
        return name

    # -- the protocol ----------------------------------------------------------------------------------------------

    def reset(self, world: World, streams: Streams) -> None:
        """Builds the scene anew, so that an episode depends on nothing before it."""
        self._free_scene()
        self._world = world
        self._streams = streams
        if world.scenario is not self._laid_out:
            self._laid_out = world.scenario
            self._layout = lay_out(world.scenario)
            self._traffic = Traffic(world.topology, self._layout.places)
        layout, robot = self._layout, self._layout.robot
        # All within is in units of the robot; what the simulation and the trace are told is not.
        self._metre, self.tick = robot.scale, TICK_SECONDS * robot.time_unit
        self._pose_ticks = max(1, round(POSE_SECONDS / self.tick))
        self._scene = Scene(
            layout.terrain, layout.boxes, layout.robots, robot=layout.models, engine=self.engine.name, gui=self._gui
        )
        self._actions = Actions(self._scene)
        self._rows: list[TraceRow] = []
        self._now = 0.0
        self._pushes = 0
        x_scale = math.dist(self._layout.places[0], self._layout.places[-1]) / (
            world.topology.distance(0, len(world.topology) - 1) or 1.0
        )
        edge_time = world.topology.mean_length * (x_scale or 1.0) / TRAVEL_SPEED + TURN_TIME
        self.edge_seconds = edge_time * robot.time_unit
        for agent in range(len(layout.robots)):
            if world.agent_status[agent] is AgentStatus.ABSENT:
                self._put_away(agent)
            else:
                self._record_pose("agent", agent)
        for box in range(len(layout.boxes)):
            if world.box_node[box] < 0:
                self._scene.place_box(box, *layout.shelf[box], 0.0)
            else:
                self._record_pose("box", box)

    def changed(self, change: Change) -> None:
        """Lets a body appear or disappear, see `Backend`."""
        scene, layout = self._open(), self._layout
        if change.kind == "add_agent":
            (agent,) = change.agents
            start = layout.robots[agent]
            scene.place_robot(agent, start.x, start.y, start.z, start.yaw)
            self._record_pose("agent", agent)
        elif change.kind == "add_box":
            start_box = layout.boxes[change.box]
            scene.place_box(change.box, start_box.x, start_box.y, self._top(change.box), start_box.yaw)
            self._record_pose("box", change.box)
        elif change.kind == "remove_box":
            scene.place_box(change.box, *layout.shelf[change.box], 0.0)

    def _put_away(self, agent: int) -> None:
        """Puts a robot where it waits until it joins."""
        layout = self._layout
        self._open().place_robot(agent, *layout.shelf[len(layout.boxes) + agent], 0.0)

    def _top(self, box: int) -> float:
        """The height at which the underside of a box comes to lie that has just appeared, metres."""
        world, layout = self._world, self._layout
        node = world.box_node[box]
        below = [other for other in world.stacks[node] if other != box]
        pit = layout.pit_at.get(node)
        floor = layout.heights[node] if pit is None else layout.heights[node] - layout.terrain.pits[pit].depth
        return floor + sum(layout.boxes[other].height for other in below)

    def reseed(self, streams: Streams) -> None:
        """Seeds the pushes that begin from now on from other streams."""
        self._streams = streams

    def feasible(self, agent: int, box: int, targets: Sequence[int]) -> Sequence[float]:
        """What geometry, the classifier or the chance of a way says, whichever was chosen."""
        world = self._world
        found = []
        for target in targets:
            if not world.can_slide(world.box_base[box], world.box_node[box], target):
                found.append(0.0)
                continue
            found.append(self._chance(agent, self._task(box, target)))
        return found

    def footprint(self, agent: int, intent: Intent) -> frozenset[Place]:
        """Travel: the target and the edges that cross the way. Push: also what staging and pushing sweep over."""
        world = self._world
        at = world.agent_node[agent]
        if not self._is_move(at, intent):
            return frozenset()
        if isinstance(intent, Push) and world.box_node[intent.box] != intent.node:
            scene = self._open()
            task = self._task(intent.box, intent.node)
            plan = plan_push(scene, intent.box, task, self._fixed_around())
            points = [staging_points(scene, intent.box, leg.start, leg.heading)[0] for leg in plan.legs]
            return self._traffic.sweep(at, intent.node, [*points, task.goal] if points else [task.goal])
        if isinstance(intent, Travel | Push):
            return self._traffic.travel(at, intent.node)
        return frozenset()

    def start(self, agent: int, intent: Intent, now: float) -> Done | None:
        """Begins a manoeuvre; its outcome comes from `advance`."""
        world, scene = self._world, self._open()
        at = world.agent_node[agent]
        if not isinstance(intent, Travel | Push) or not self._is_move(at, intent):
            return Done(0.0, Outcome("blocked", at, reason="no such move"))
        if not scene.has_robot(agent) or self._actions.get(agent) is not None:
            reason = "no robot" if self._actions.get(agent) is None else "busy"
            return Done(0.0, Outcome("blocked", at, reason=reason))
        self._now = now
        log = self._log_for(agent)
        if isinstance(intent, Travel):
            if not world.passable(world.level(agent), at, intent.node):
                return Done(0.0, Outcome("blocked", at, reason="unreachable"))
            manoeuvre = self._drive(agent, self._layout.places[intent.node], log)
        elif world.box_node[intent.box] == intent.node:
            if not world.graspable(agent, intent.box, world.level(agent), at):
                return Done(0.0, Outcome("blocked", at, reason="out of reach"))
            manoeuvre = self._drive(agent, self._beside(agent, intent.box), log)
        else:
            base = world.box_base[intent.box]
            if world.top[at] != intent.box or not world.can_slide(base, at, intent.node):
                return Done(0.0, Outcome("blocked", at, reason="cannot be pushed"))
            self._pushes += 1
            task = self._task(intent.box, intent.node)
            manoeuvre = self._execute(
                scene, agent, task, everything_else(scene, agent), log,
                self._streams.derive(f"push/{self._pushes}") % 2**31,
            )  # fmt: skip
        self._actions.begin(agent, Action(intent, manoeuvre, at))
        return None

    def advance(self, now: float) -> Sequence[Finished]:
        """One control tick for all robots; then whoever's manoeuvre has ended says so."""
        scene = self._open()
        self._now = now
        finished = [Finished(over[0], self._outcome(*over)) for over in self._actions.go_on()]
        scene.tick()
        if self.recording and scene.ticks % self._pose_ticks == 0:
            self._record_movers()
        return finished

    def cancel(self, agent: int) -> None:
        """Stops the robot where it is."""
        self._actions.end(agent)

    def leave(self, agent: int) -> None:
        """Takes the robot out of the scene."""
        self.cancel(agent)
        scene = self._open()
        if scene.has_robot(agent):
            self._record_pose("agent", agent)
            scene.remove_robot(agent)

    def rows(self) -> Iterable[TraceRow]:
        """Poses of movers and control steps since the last call."""
        rows, self._rows = self._rows, []
        return rows

    def close(self) -> None:
        """Frees the scene."""
        self._free_scene()

    # -- manoeuvres ------------------------------------------------------------------------------------------------

    def _is_move(self, at: int, intent: Intent) -> bool:
        """Whether an intent leads from a node along an edge, and its box, if any, exists."""
        if not isinstance(intent, Travel | Push) or intent.node not in self._world.topology.neighbours[at]:
            return False
        return isinstance(intent, Travel) or 0 <= intent.box < len(self._world.box_node)

    def _open(self) -> Scene:
        if self._scene is None:
            raise ColonysimError("the backend was closed, or not yet reset")
        return self._scene

    def _free_scene(self) -> None:
        if self._scene is not None:
            for agent, _ in self._actions.under_way():
                self._actions.end(agent)
            self._scene.close()
            self._scene = None

    def _drive(self, agent: int, place: tuple[float, float], log: Log) -> Manoeuvre:
        scene = self._open()
        return drive_to(scene, agent, *place, everything_else(scene, agent), tolerance=ARRIVAL, log=log)

    def _beside(self, agent: int, box: int) -> tuple[float, float]:
        """Where a robot that takes hold of a box drives to: straight up to it, but not into contact."""
        scene = self._open()
        robot, at = scene.robot(agent), scene.box(box)
        away = math.dist(robot[:2], at[:2])
        share = max(0.0, 1.0 - APPROACH / away) if away > 0.0 else 0.0
        return robot.x + share * (at.x - robot.x), robot.y + share * (at.y - robot.y)

    def _task(self, box: int, target: int, start: int = -1) -> PushTask:
        """The push of a box to a node, from where the world has it or from another node."""
        world, layout = self._world, self._layout
        at = world.box_node[box] if start < 0 else start
        pit = layout.pit_at.get(target)
        if pit is not None and not self._open().pit_filled(layout.terrain.pits[pit]):
            return PushTask(box, layout.places[at], layout.places[target], "hole", layout.heights[target], pit)
        kind: Kind = "slope" if (at, target) in world.topology.rises else "flat"
        return PushTask(box, layout.places[at], layout.places[target], kind, layout.heights[target])

    def _fixed_around(self) -> Surroundings:
        """Boxes and open pits: what a plan must avoid; robots move on."""
        scene = self._open()
        seen = everything_else(scene, -1)()
        return Surroundings((), seen.boxes, seen.open_pits)

    def _chance(self, agent: int, task: PushTask) -> float:
        scene = self._open()
        if self._way_chance is not None:
            return chances_along(scene, agent, [task], self._fixed_around(), self._way_chance)[0]
        if self._forest is not None:
            return chance_of_push(scene, agent, task, self._forest, self._fixed_around())
        return 1.0 if plan_push(scene, task.box, task, self._fixed_around()).margin >= 0.0 else 0.0

    @property
    def feasible_way(self) -> FeasibleWay | None:
        """An optional part of the protocol; None unless `feasibility` is "way"."""
        return self._along if self._way_chance else None

    def _along(self, agent: int, box: int, way: Sequence[int]) -> Sequence[float]:
        """The chance of each push of a way; 0 from where the rules of the place forbid one."""
        world = self._world
        base, tasks = world.box_base[box], []
        for i, j in itertools.pairwise(way):
            if not world.can_slide(base, i, j):
                break
            tasks.append(self._task(box, j, i))
            base = world.surface[j]
        assert self._way_chance is not None
        told = chances_along(self._open(), agent, tasks, self._fixed_around(), self._way_chance)
        return [*told, *itertools.repeat(0.0, max(0, len(way) - 1 - len(told)))]

    # -- outcomes --------------------------------------------------------------------------------------------------

    def _outcome(self, agent: int, action: Action, result: ManoeuvreResult) -> Outcome:
        scene, world, intent = self._open(), self._world, action.intent
        self._actions.end(agent)
        fault = scene.robot_fault(agent)
        lost = fault is not None or result.reason in FAULTS
        boxes = self._moved_boxes(intent.box if isinstance(intent, Push) else -1)
        self._record_pose("agent", agent)
        for place in boxes:
            self._record_pose("box", place.box)
        reason = "" if result.success else (fault or result.reason)
        if isinstance(intent, Push) and world.box_node[intent.box] != intent.node:
            landed = next((place for place in boxes if place.box == intent.box), None)
            arrived = landed is not None and landed.node == intent.node and not landed.stray
            node = intent.node if arrived and intent.node not in self._layout.pit_at else action.origin
            if arrived and intent.node in self._layout.pit_at:
                base, rise = world.box_base[intent.box], world.topology.rises.get((action.origin, intent.node), 0.0)
                if base + rise - world.surface[intent.node] < world.scenario.reach:
                    node = intent.node
            why = "" if arrived and not lost else reason or "stray"
            return Outcome("arrived" if arrived else "failed", node, boxes, why, lost)
        if result.success:
            keeps = (action.origin,) if isinstance(intent, Push) else ()
            return Outcome("arrived", intent.node, boxes, lost=lost, reason=fault or "", keeps=keeps)
        robot, places = scene.robot(agent), self._layout.places
        nearer = math.dist(robot[:2], places[intent.node]) < math.dist(robot[:2], places[action.origin])
        took = isinstance(intent, Push)
        # The goal is only reached by getting there: whoever belongs to it leaves.
        node = intent.node if nearer and not took and intent.node != world.goal else action.origin
        keeps = () if lost else (action.origin if node == intent.node else intent.node,)
        return Outcome("failed" if lost else "blocked", node, boxes, reason, lost, () if took else keeps)

    def _moved_boxes(self, pushed: int) -> tuple[BoxPlace, ...]:
        """Where the pushed box is, and every other box that is no longer where the world has it."""
        scene, world, layout = self._open(), self._world, self._layout
        # What another robot is pushing is told with that push's own outcome.
        underway = {action.intent.box for _, action in self._actions.under_way() if isinstance(action.intent, Push)}
        places = []
        for box in range(len(layout.boxes)):
            if box in underway:
                continue
            pose, node = scene.box(box), world.box_node[box]
            if node < 0:
                continue
            if not all(map(math.isfinite, pose)):
                places.append(BoxPlace(box, node, stray=True))
                continue
            pit = self._pit_of(box)
            if pit is not None:
                if pit != node:
                    places.append(BoxPlace(box, pit))
                continue
            off = math.dist(pose[:2], layout.places[node])
            if box != pushed and (off <= layout.stray_beyond or world.box_stray[box]):
                continue
            here = min(
                (n for n in range(len(layout.places)) if n not in layout.pit_at or self._filled(n)),
                key=lambda n: math.dist(pose[:2], layout.places[n]),
            )
            stray = math.dist(pose[:2], layout.places[here]) > layout.stray_beyond
            if here != node or stray != world.box_stray[box]:
                places.append(BoxPlace(box, here, stray))
        return tuple(places)

    def _pit_of(self, box: int) -> int | None:
        """The hole's node in whose pit a box is seated, or None."""
        scene = self._open()
        for node, pit in self._layout.pit_at.items():
            if scene.box_seated(box, self._layout.terrain.pits[pit]):
                return node
        return None

    def _filled(self, node: int) -> bool:
        return self._open().pit_filled(self._layout.terrain.pits[self._layout.pit_at[node]])

    # -- the trace -------------------------------------------------------------------------------------------------

    def _record_pose(self, body: str, number: int) -> None:
        if not self.recording:
            return
        scene = self._open()
        pose = scene.robot(number) if body == "agent" else scene.box(number)
        self._rows.append(TraceRow("poses", (self._now, body, number, *self._in_metres(pose))))

    def _record_movers(self) -> None:
        """Where whoever is doing something is, and the boxes being pushed."""
        scene, rows, now = self._open(), self._rows, self._now
        # Half the time of TraceRow(...).
        for agent, action in self._actions.under_way():
            rows.append(_make(TraceRow, ("poses", (now, "agent", agent, *self._in_metres(scene.robot(agent))))))
            if isinstance(action.intent, Push):
                box = action.intent.box
                rows.append(_make(TraceRow, ("poses", (now, "box", box, *self._in_metres(scene.box(box))))))

    def _in_metres(self, pose: Pose) -> Pose:
        """A pose of the scene as the trace keeps it."""
        metre = self._metre
        return pose if metre == 1.0 else pose._replace(x=metre * pose.x, y=metre * pose.y, z=metre * pose.z)

    def _log_for(self, agent: int) -> Log:
        if not self.recording:
            return ignore

        def log(chooser: str, control: str, ticks: int) -> None:
            self._rows.append(TraceRow("controls", (self._now, agent, chooser, control, ticks)))

        return log


def _check_window(engine: str) -> None:
    """Finds out before anything is recorded whether a window can be shown."""
    if trouble := window_trouble(engine):
        raise ColonysimError(f"gui: {trouble}")
    if trouble := display_trouble():
        raise ColonysimError(f"gui: no window can be opened on this display, or there is none: {trouble}")
