"""Makes the pictures and replay pages of the gallery: `python docs/gallery/make.py [NAME ...]`, without a network.

Each colony is run anew, from its scenario beside this file. A picture is the last episode seen from above, at a chosen
moment; it is committed. A replay page, `NAME.html`, is not; `docs/build.py` has those made that are missing.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import colonysim
from colonysim.files import replace_file, replacing
from colonysim.view import write_page

if TYPE_CHECKING:
    from numpy.typing import NDArray

HERE = Path(__file__).resolve().parent
SIZE = (720, 540)
COLOURS = 64
FRAMES = 800


class Exhibit(NamedTuple):
    """A colony of the gallery.

    Attributes:
        name: Of its page and its picture.
        moment: Share of the last episode's time at which the picture is taken.
        scenario: Where that is another one than the file of its name.
        backend: What moves the robots.
        policies: One run for each, side by side on the picture; the replay is that of the last. None: the scenario's.
        record: What its run keeps; None for everything.
        episodes: How many; None for what the scenario says.
    """

    name: str
    moment: float = 1.0
    scenario: str = ""
    backend: str = "nodeworld"
    policies: Sequence[str | None] = (None,)
    record: Sequence[str] | None = None
    episodes: int | None = None


EXHIBITS = (
    Exhibit("ditch", 0.7),
    Exhibit("deep", 0.75),
    Exhibit("door", 0.3),
    Exhibit("bridges", 0.6),
    Exhibit("fleeing", 0.5),
    Exhibit("dying", 0.6),
    Exhibit("scouts", 0.55),
    Exhibit("worn-out", 0.6),
    Exhibit("rounds", 0.3),
    Exhibit("thousand", 0.15, record=("events",)),
    Exhibit("chance", 0.9, policies=("random", "colony")),
    Exhibit("hard", 0.6, scenario="hard", backend="physics", episodes=2),
)


def make(exhibit: Exhibit, picture: bool) -> None:
    """Runs a colony and writes its replay page, and its picture if that is wanted."""
    images = []
    with tempfile.TemporaryDirectory() as folder:
        for policy in exhibit.policies:
            run = colonysim.run(
                exhibit.scenario or HERE / f"{exhibit.name}.yaml", backend=exhibit.backend, policy=policy, seed=1,
                episodes=exhibit.episodes, record=exhibit.record, out=Path(folder) / (policy or "run"),
            )  # fmt: skip
            if picture:
                images.append(seen_from_above(run, exhibit.moment))
            write_page(run, HERE / f"{exhibit.name}.html")
    if picture:
        save(images, HERE / f"{exhibit.name}.png")


def seen_from_above(run: colonysim.Run, moment: float) -> NDArray:
    """The last episode of a run at a moment: an image, height x width x 3."""
    from colonysim.video.film import Film

    last = run.episodes[-1]
    film = Film(run.only([last.episode]), last, frames=FRAMES, fps=10, size=SIZE)
    return film[round(moment * (FRAMES - 1))].copy()


def save(images: Sequence[NDArray], path: Path) -> None:
    """Writes images side by side as one small PNG."""
    import numpy as np
    from PIL import Image

    picture = Image.fromarray(np.concatenate(images, axis=1))
    with replacing(path) as temporary:
        picture.quantize(COLOURS).save(temporary, format="PNG", optimize=True)


def make_missing_replays() -> None:
    """Makes the replay pages that are not there; where there is no physics engine, a page that says so."""
    from colonysim.physics import default_engine, engine_trouble

    for exhibit in EXHIBITS:
        page = HERE / f"{exhibit.name}.html"
        if page.is_file():
            continue
        print(f"replay of {exhibit.name} ...", flush=True)
        if exhibit.backend == "physics" and (trouble := engine_trouble(default_engine())):
            replace_file(page, f"<!doctype html><title>{exhibit.name}</title><p>No replay: {trouble}\n")
        else:
            make(exhibit, picture=False)


def main() -> int:
    """Makes what was asked for, or everything."""
    names = [exhibit.name for exhibit in EXHIBITS]
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else None)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"which: {', '.join(names)} (all of them)")
    wanted = parser.parse_args().names
    if unknown := [name for name in wanted if name not in names]:
        parser.error(f"no {unknown[0]!r} in the gallery; there are {', '.join(names)}")
    for exhibit in EXHIBITS:
        if not wanted or exhibit.name in wanted:
            print(exhibit.name, flush=True)
            make(exhibit, picture=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
