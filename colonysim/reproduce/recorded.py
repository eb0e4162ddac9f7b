"""Runs that are recorded because something in them is drawn or looked at, and those drawings."""

from __future__ import annotations

import shutil
from dataclasses import dataclass, replace
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from colonysim import __version__
from colonysim.errors import TraceError
from colonysim.files import replace_file
from colonysim.provenance import parts_of
from colonysim.recording import run
from colonysim.scenario.loading import load_scenario
from colonysim.trace.manifest import MANIFEST
from colonysim.trace.reader import Run

if TYPE_CHECKING:
    from pathlib import Path

    from colonysim.reproduce.plans import Size

__all__ = ["DRAWINGS", "RUNS", "Drawing", "Recording", "drawn", "recorded"]

_RECORD = ("deposits", "poses", "controls", "frames")
"""What is kept of a run: all but the decisions, which no drawing shows."""


@dataclass(frozen=True)
class Recording:
    """What is run: as in the paper, the node world acts at once on sanity and easy, else in its own time.

    The backend "physics" stands for the engine of a reproduction.
    """

    scenario: str
    variant: str | None = None
    policy: str = "paper"
    mode: str = "synchronous"
    backend: str = "nodeworld"

    def under(self, policy: str) -> Recording:
        """The same with another policy."""
        return replace(self, policy=policy)

    def on(self, engine: str) -> Recording:
        """The same with the rigid-body engine in the place of "physics"."""
        return replace(self, backend=engine) if self.backend == "physics" else self


RUNS = {
    "sanity": Recording("sanity"),
    "sanity-r3": Recording("sanity", "r3"),
    "easy": Recording("easy"),
    "medium": Recording("medium", mode="asynchronous"),
    "hard": Recording("hard", "r20-4", mode="asynchronous"),
    "hard-r5-4": Recording("hard", "r5-4", mode="asynchronous"),
    "hard-r5-6": Recording("hard", "r5-6", mode="asynchronous"),
    "hard-r5-6-colony": Recording("hard", "r5-6", "colony", "asynchronous"),
    "physics-easy": Recording("easy", None, "colony", "asynchronous", "physics"),
    "physics-medium": Recording("medium", None, "colony", "asynchronous", "physics"),
    "physics-hard": Recording("hard", "r20-4", "colony", "asynchronous", "physics"),
}


@dataclass(frozen=True)
class Drawing:
    """An image of a run: `what` as for `colonysim plot`, of up to three episodes; 0 stands for the last."""

    run: str
    what: str
    episodes: tuple[int, ...]
    hole: int | None = None
    box: int | None = None


DRAWINGS = {
    "sanity-D": Drawing("sanity", "D", (1, 2, 4)),
    "sanity-E": Drawing("sanity", "E", (1, 3, 0)),
    "sanity-B": Drawing("sanity", "B", (1, 4, 0), box=1),
    "sanity-trajectories": Drawing("sanity", "trajectories", (0,)),
    "sanity-H": Drawing("sanity-r3", "H", (1, 2, 4), hole=7),
    "easy-D": Drawing("easy", "D", (1, 2, 3)),
    "easy-E": Drawing("easy", "E", (1, 3, 0)),
    "easy-trajectories": Drawing("easy", "trajectories", (1, 4, 0)),
    "medium-D": Drawing("medium", "D", (1, 0)),
    "medium-B": Drawing("medium", "B", (1, 4, 0), box=2),
    "medium-trajectories": Drawing("medium", "trajectories", (1, 0)),
    "hard-D": Drawing("hard", "D", (1, 0)),
    "hard-trajectories": Drawing("hard", "trajectories", (0,)),
    "hard-r5-4-H": Drawing("hard-r5-4", "H", (1, 0), hole=29),
    "hard-r5-6-H": Drawing("hard-r5-6", "H", (1, 0), hole=29),
    "hard-r5-6-trajectories": Drawing("hard-r5-6-colony", "trajectories", (0,)),
    "physics-easy": Drawing("physics-easy", "trajectories", (1, 3, 4)),
    "physics-medium": Drawing("physics-medium", "trajectories", (1, 3, 4)),
    "physics-hard": Drawing("physics-hard", "trajectories", (1, 0)),
}


def recorded(what: Recording, size: Size, folder: Path, seed: int | None = None) -> Run:
    """A recorded run, from its directory if it is there and finished.

    Args:
        what: What is run.
        size: Its episodes and its engine; its first seed is the default.
        folder: Holds a directory for each run.
        seed: Another seed.
    """
    seed = size.first_seed if seed is None else seed
    episodes = size.driven if what.backend == "physics" else size.episodes
    what = what.on(size.engine)
    words = (what.scenario, what.variant, what.policy, what.mode, what.backend, f"s{seed}", str(episodes))
    directory = folder / "-".join(word for word in words if word)
    if directory.exists():
        try:
            there = Run.open(directory)
            if there.status == "finished" and _is_as_now(there, what, seed) and there.verify():
                return there
        except TraceError:
            pass  # killed before its first line, or damaged since
        shutil.rmtree(directory)
    return run(
        what.scenario, variant=what.variant, policy=what.policy, mode=what.mode, backend=what.backend,
        episodes=episodes, seed=seed, out=directory, record=_RECORD,
    )  # fmt: skip


def _is_as_now(there: Run, what: Recording, seed: int) -> bool:
    """Whether the run would be the same today."""
    scenario, manifest = load_scenario(what.scenario, what.variant), there.manifest
    return (
        manifest.get("versions", {}).get("colonysim") == __version__
        and manifest.get("seed") == seed
        and manifest.get("scenario_sha256") == scenario.digest
        and manifest.get("sources", {})
        == parts_of(what.policy, what.backend, scenario.parameters, None, scenario.parts_of_groups)
    )


def drawn(name: str, size: Size, runs: Path, images: Path) -> Path:
    """Draws one of `DRAWINGS`, or takes the drawing that lies beside its run if it is newer than the run."""
    from colonysim.plots import draw

    what = DRAWINGS[name]
    source = recorded(RUNS[what.run], size, runs)
    assert source.path is not None
    kept = runs / "drawings" / f"{source.path.name}-{name}.png"
    if not kept.exists() or kept.stat().st_mtime < (source.path / MANIFEST).stat().st_mtime:
        last = source.episodes[-1].episode
        chosen = tuple(dict.fromkeys(min(number, last) or last for number in what.episodes))
        kept.parent.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(dir=kept.parent) as scratch:
            [made] = draw(source, what=[what.what], episodes=chosen, hole=what.hole, box=what.box, out=scratch, dpi=80)
            made.replace(kept)
    image = images / f"{name}.png"
    replace_file(image, kept.read_bytes())
    return image
