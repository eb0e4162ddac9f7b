"""Runs what the studies need and writes the report."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from colonysim.errors import ColonysimError
from colonysim.files import alone, replace_file
from colonysim.physics import engine_trouble
from colonysim.processes import refuse_unguarded
from colonysim.reproduce import plans
from colonysim.reproduce.context import Context
from colonysim.reproduce.document import Block, Heading, Text, as_html, as_markdown
from colonysim.reproduce.evidence import Evidence, Measured, found_by, stored_in_physics
from colonysim.reproduce.fit import fit_part, held_out
from colonysim.reproduce.pages import PAGES, report
from colonysim.reproduce.paper import the_paper
from colonysim.reproduce.push import Trainings
from colonysim.reproduce.push_study import push_part
from colonysim.reproduce.studies import ablation_part, asynchrony_part, drawings_part, nodeworld_part, physics_part
from colonysim.suggest import nearest
from colonysim.sweep import Store, run_planned

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from colonysim.reproduce.paper import Paper
    from colonysim.sweep.workers import Outcome

__all__ = ["STUDIES", "Made", "Study", "reproduce", "stored"]


@dataclass(frozen=True)
class Study:
    """A part of the report.

    Attributes:
        title: Its heading.
        places: The paper's figures and tables that it is about.
        part: Makes its blocks.
        trials: The sweeps it needs.
        physics: Whether it needs a rigid-body engine.
        then: Makes the sweeps that depend on what the first ones have found.
        page: The page that it stands on, one of `pages.PAGES`.
    """

    title: str
    places: str
    part: Callable[[Context], list[Block]]
    trials: Callable[[plans.Size], list[dict[str, Any]]] = lambda size: []
    physics: bool = False
    then: Callable[[plans.Size, Evidence, Paper], list[dict[str, Any]]] | None = None
    page: str = "pheromones"


def _drawings(study: str, *names: str) -> Callable[[Context], list[Block]]:
    return lambda context: drawings_part(context, study, names)


STUDIES = {
    "performance-nodeworld": Study(
        "Performance on the node world", "PerformanceEasyMedium, HardResults", nodeworld_part, plans.nodeworld,
        page="performance",
    ),
    "performance-physics": Study(
        "Performance in physics", "PerformanceEasyMedium, HardResults", physics_part, plans.physics, physics=True,
        page="performance",
    ),
    "ablation-sanity": Study(
        "Ablations on sanity", "AblationSanity", lambda context: ablation_part(context, "sanity"),
        lambda size: plans.ablation(size, "sanity"), page="ablations",
    ),
    "ablation-easy": Study(
        "Ablations on easy", "AblationEasy", lambda context: ablation_part(context, "easy"),
        lambda size: plans.ablation(size, "easy"), page="ablations",
    ),
    "fit": Study(
        "The parameters that the paper does not print", "PerformanceEasyMedium, HardResults", fit_part, plans.fit,
        then=held_out, page="fit",
    ),
    "asynchrony": Study(
        "Asynchronous against synchronous", "Section 3.5.2, Deadlock", asynchrony_part, plans.asynchrony,
        page="ablations",
    ),
    "pheromones-sanity": Study(
        "Pheromones on sanity", "SanityDevelopment",
        _drawings("pheromones-sanity", "sanity-D", "sanity-E", "sanity-B", "sanity-trajectories"),
    ),
    "hole-edge-case": Study("The edge case of H", "HPheromoneEdgeCase", _drawings("hole-edge-case", "sanity-H")),
    "pheromones-easy": Study(
        "Pheromones on easy", "EasyDPheromone, EasyEPheromone, EasyTrajectoryFourth",
        _drawings("pheromones-easy", "easy-D", "easy-E", "easy-trajectories"),
    ),
    "pheromones-medium": Study(
        "Pheromones on medium", "MediumPheromones, MediumBPheromone, MediumTrajectoryEnd",
        _drawings("pheromones-medium", "medium-D", "medium-B", "medium-trajectories"),
    ),
    "pheromones-hard": Study(
        "Pheromones on hard",
        "HardDPheromone, HardTrajectoriesEnd, Hard4HPheromone, Hard6HPheromone, HardTrajectoriesEnd2",
        _drawings(
            "pheromones-hard", "hard-D", "hard-trajectories", "hard-r5-4-H", "hard-r5-6-H", "hard-r5-6-trajectories"
        ),
    ),
    "trajectories-physics": Study(
        "Trajectories in physics",
        "EasyTrajectoryFirst, EasyTrajectoryThird, EasyTrajectoryFourth, MediumTrajectoryFirst, HardTrajectoriesEnd",
        _drawings("trajectories-physics", "physics-easy", "physics-medium", "physics-hard"), physics=True,
    ),
    "push": Study("The push", "SingleDDQNAblation, PolicyStyleTest", push_part, page="push"),
}  # fmt: skip
"""What can be reproduced, by name."""
_STORED = "performance-physics"
"""The study whose runs may be taken from a file."""
_TRAINED = "push"
"""The study that needs trainings."""


@dataclass(frozen=True)
class Made:
    """What a reproduction has made.

    Attributes:
        markdown: The first page of the report; the others and the images are beside it.
        html: All of it in one file.
        verdicts: How often each word was said.
        gaps: What is missing, and why.
    """

    markdown: Path
    html: Path
    verdicts: Counter[str]
    gaps: tuple[str, ...]


def reproduce(
    out: str | Path,
    names: Sequence[str] = (),
    *,
    size: plans.Size = plans.FULL,
    workers: int | None = None,
    physics: Sequence[str | Path] = (),
    trainings: str | Path | None = None,
    on_outcome: Callable[[Outcome, int, int], None] | None = None,
    on_study: Callable[[str], None] | None = None,
) -> Made:
    """Runs studies and writes `reproduction/index.md`, its pages, and `reproduction.html`; nothing is run twice.

    The report is of these studies alone: pages of others that an earlier call has written there are removed.

    Args:
        out: The directory: report, images, trials and recorded runs.
        names: Which of `STUDIES`; all if empty.
        size: How much is run.
        workers: Trials at a time; None: one for each processor.
        physics: Files of stored runs in physics, one for each engine, to take instead of running them.
        trainings: Stored trainings of the push; by default those that come with the package.
        on_outcome: Called when a trial begins or ends, with how many are done and how many there are.
        on_study: Called with the name of each study before it is written.

    Raises:
        ColonysimError: There is no such study, something needed is not installed, a file cannot be read or written, or
            two of them hold runs on the same engine.
    """
    refuse_unguarded()
    out = Path(out)
    for name in names:
        if name not in STUDIES:
            raise ColonysimError(f"nothing to reproduce by the name {name!r}; {nearest(name, STUDIES)}")
    chosen = {name: study for name, study in STUDIES.items() if name in names or not names}
    asked_for = [(given, "runs in physics", _STORED) for given in physics]
    asked_for += [(trainings, "trainings", _TRAINED)] if trainings is not None else []
    for given, what, needed in asked_for:
        if needed not in chosen:
            raise ColonysimError(f"{given}: stored {what} are of use to {needed!r} only, which is not asked for")
    kept: list[Measured] = []
    gaps: list[str] = []
    stored_in: dict[str, str] = {}
    for given in physics:
        engine, runs, damaged = stored_in_physics(Path(given))
        if engine in stored_in:
            raise ColonysimError(f"{given}: holds runs on {engine}, as {stored_in[engine]} does; give one of them")
        stored_in[engine] = Path(given).name
        kept += runs
        gaps += damaged
    source = (Path(trainings) if trainings else stored("push_ablation.jsonl")) if _TRAINED in chosen else None
    trained, damaged = Trainings.read(source) if source else ([], [])
    gaps += damaged
    if trouble := engine_trouble(size.engine):
        without = [name for name, study in chosen.items() if study.physics and not (kept and name == _STORED)]
        gaps += [f"{name}: {trouble}" for name in without]
        chosen = {name: study for name, study in chosen.items() if name not in without}
    documents = [
        document for name, study in chosen.items() if not (kept and name == _STORED) for document in study.trials(size)
    ]
    with alone(out, "is reproducing the paper there"):
        measured: list[Measured] = []
        if documents:
            with Store(out / "trials", write=True) as store:
                trials = plans.asked(documents)
                run_planned(plans.joined(trials), store, workers=workers, on_outcome=on_outcome)
                measured, missing = found_by(trials, store)
                following = [study.then for study in chosen.values() if study.then is not None]
                if following:
                    found = Evidence(measured)
                    more = [document for then in following for document in then(size, found, the_paper())]
                    trials += plans.asked(more)
                    run_planned(plans.joined(trials), store, workers=workers, on_outcome=on_outcome)
                    measured, missing = found_by(trials, store)
            gaps += [f"trial {line}" for line in missing]
        context = Context(
            out=out, size=size, paper=the_paper(), evidence=Evidence([*measured, *kept]), trainings=trained,
            stored_in=stored_in, gaps=gaps,
        )  # fmt: skip
        pages: dict[str, list[Block]] = {}
        for name, study in chosen.items():
            if on_study is not None:
                on_study(name)
            about = f"Made by `colonysim reproduce {name}`. In the paper: {study.places}."
            pages.setdefault(study.page, []).extend([Heading(2, study.title), Text(about), *study.part(context)])
        written = report(context, pages, _asked(list(chosen), size, physics, trainings))
        for page in written:
            replace_file(context.pages / f"{page.name}.md", as_markdown(page.blocks))
        for gone in PAGES.keys() - pages.keys():  # of a report of other studies that was here before
            (context.pages / f"{gone}.md").unlink(missing_ok=True)
        markdown, html = context.pages / "index.md", out / "reproduction.html"
        replace_file(html, as_html(written, context.pages))
    return Made(markdown, html, Counter(judged.verdict.word for judged in context.judged), tuple(context.gaps))


def stored(name: str) -> Path | None:
    """A file of results that comes with the package: inside a wheel, or beside it in a checkout."""
    package = Path(__file__).resolve().parent
    for path in (package / "results" / name, package.parent.parent / "docs" / "results" / name):
        if path.is_file():
            return path
    return None


def _asked(names: Sequence[str], size: plans.Size, physics: Sequence[str | Path], trainings: str | Path | None) -> str:
    """The command's arguments; of files the name, for where they lie is nobody else's business."""
    words = [] if list(names) == list(STUDIES) else list(names)
    quick = size == replace(plans.QUICK, seeds=size.seeds, first_seed=size.first_seed, engine=size.engine)
    words += ["--quick"] if quick else []
    usual = plans.QUICK if quick else plans.FULL
    words += [f"--seeds {size.seeds}"] if size.seeds != usual.seeds else []
    words += [f"--first-seed {size.first_seed}"] if size.first_seed != usual.first_seed else []
    words += [f"--engine {size.engine}"] if size.engine != usual.engine else []
    words += [f"--physics {Path(given).name}" for given in physics]
    words += [f"--trainings {Path(trainings).name}"] if trainings else []
    return "".join(f" {word}" for word in words)
