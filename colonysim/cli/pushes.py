"""The run directory of an evaluation of single pushes: the tables of any run, and the ground of each push."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import time
from typing import TYPE_CHECKING, Any

from colonysim.arguments import as_seed, whole
from colonysim.learning.cards import load_model
from colonysim.physics import STANDARD, engine_facts
from colonysim.push.training.evaluation import judged_start
from colonysim.push.training.starts import KINDS, distribution
from colonysim.trace.manifest import begin_manifest, prepare_directory
from colonysim.trace.schema import EpisodeResult, Event
from colonysim.trace.writer import TraceWriter

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path
    from types import TracebackType

    from colonysim.physics import EngineName, Pose, Scene
    from colonysim.push.executors import ExecutorName
    from colonysim.push.task import Chooser, Kind
    from colonysim.push.training.evaluation import Played
    from colonysim.push.training.starts import Start

__all__ = ["PushRecorder"]

_STARTS = "push"
_POSE_TICKS = 6
"""Ten poses a second, as in the runs of colonies."""


class PushRecorder:
    """Looks on at an evaluation (`colonysim.push.training.evaluation.Watch`) and writes its run directory.

    Each push is an episode, counted from 1 through all terrains: poses of agent 0 and box 0, controls, one event and
    one result. Where it happens, and from where to where it goes, is in the manifest below `evaluation`.

    Args:
        directory: Where to write; absent or empty.
        push: The executor.
        engine: The rigid-body engine; it stands in the manifest as the run's backend.
        episodes: Pushes per terrain.
        seed: Makes the episodes.
        model: The network; None is the shipped one.

    Attributes:
        done: Pushes recorded so far.

    Raises:
        ColonysimError: The directory holds files already, or the model is missing or damaged.
        MissingEngineError: The engine is not installed.
    """

    def __init__(
        self,
        directory: Path,
        push: ExecutorName,
        *,
        engine: EngineName,
        episodes: int,
        seed: int,
        model: Path | None = None,
    ) -> None:
        seed, episodes = as_seed(seed), whole("episodes", episodes)
        network = None if push == "scripted" else load_model("push" if model is None else model, "q-network")
        manifest = begin_manifest(
            "push", backend=engine, policy=push, mode="single pushes", episodes=len(KINDS) * episodes, seed=seed,
            engine=engine_facts(engine),
        )  # fmt: skip
        manifest["evaluation"] = {
            "executor": push,
            "model": network and network.name,
            "model_sha256": network and network.card["sha256"],
            "starts": _STARTS,
            "starts_sha256": _digest(dataclasses.asdict(distribution(_STARTS))),
            "robot_size": [STANDARD.length, 2 * STANDARD.half_width],
            "results": None,
            "pushes": [
                {
                    "episode": _numbered(kind, number, episodes),
                    **_ground(kind, judged_start(kind, number, seed=seed, starts=_STARTS)[0]),
                }
                for kind in KINDS
                for number in range(episodes)
            ],
        }
        self.done = 0
        self._per_terrain = episodes
        self._kind: Kind = "flat"
        self._episode = 0
        self._begun = 0.0
        self._ticks = 0
        self._last: tuple[float, Pose, Pose] | None = None
        self._recorded = True
        self._manifest = manifest
        self._writer = TraceWriter(prepare_directory(directory, manifest), manifest)

    def begin(self, kind: Kind, number: int) -> None:
        """A push is about to begin."""
        self._kind = kind
        self._episode = _numbered(kind, number, self._per_terrain)
        self._ticks, self._begun = 0, time.monotonic()
        self._last, self._recorded = None, True

    def tick(self, scene: Scene) -> None:
        """Takes the poses, and keeps those of every sixth tick."""
        self._last, self._recorded = (scene.time, scene.robot(0), scene.box(0)), False
        if self._ticks % _POSE_TICKS == 0:
            self._record()
        self._ticks += 1

    def control(self, chooser: Chooser, control: str, ticks: int) -> None:
        """Someone chose a control."""
        now = 0.0 if self._last is None else self._last[0]
        self._writer.write("controls", (self._episode, now, 0, chooser, control, ticks))

    def end(self, played: Played) -> None:
        """The push has ended: its last poses, its event and its result."""
        if not self._recorded:
            self._record()
        status = "arrived" if played.success else "failed"
        reason = "" if played.success else played.reason
        self._writer.write(
            "events",
            Event(self._episode, played.seconds, "end", 0, "push", box=0, status=status, reason=reason, step=1),
        )
        seated = int(played.success and self._kind == "hole")
        spent = time.monotonic() - self._begun
        self._writer.write(
            "episodes",
            EpisodeResult(self._episode, 1, float(played.success), played.reason, played.seconds, seated, spent),
        )
        self.done += 1

    def results(self, found: Mapping[str, Any]) -> None:
        """Keeps the figures of the evaluation beside what they were measured on."""
        self._manifest["evaluation"]["results"] = dict(found)

    def __enter__(self) -> PushRecorder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._writer.__exit__(kind, error, trace)

    def _record(self) -> None:
        if self._last is None:
            return
        now, robot, box = self._last
        self._writer.write("poses", (self._episode, now, "agent", 0, *robot))
        self._writer.write("poses", (self._episode, now, "box", 0, *box))
        self._recorded = True


def _numbered(kind: Kind, number: int, per_terrain: int) -> int:
    return KINDS.index(kind) * per_terrain + number + 1


def _ground(kind: Kind, start: Start) -> dict[str, Any]:
    """What a push happens on, as plain data: metres and radians."""
    terrain, robot, box = start.terrain, start.robot, start.box
    return {
        "terrain": kind,
        "robot": [robot.x, robot.y, robot.yaw],
        "box": [box.x, box.y, box.yaw],
        "box_length": box.length,
        "start": list(start.task.start),
        "goal": list(start.task.goal),
        "pits": [dataclasses.asdict(pit) for pit in terrain.pits],
        "ramps": [dataclasses.asdict(ramp) for ramp in terrain.ramps],
    }


def _digest(value: Any) -> str:
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()
