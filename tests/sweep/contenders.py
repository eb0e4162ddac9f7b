"""Two processes that want the same directory at the same moment, again and again."""

from __future__ import annotations

import multiprocessing
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

import colonysim
from colonysim.errors import ColonysimError
from colonysim.reproduce.making import reproduce
from colonysim.reproduce.plans import QUICK
from colonysim.sweep import run_sweep
from colonysim.sweep.tuning import tune

SWEEP = "scenarios: [sanity]\nseeds: [1]\nepisodes: 1\n"
SEARCH = "scenarios: [sanity]\nsample: {count: 1, ranges: {policy.epsilon: [0.1, 0.9]}}\nseeds: [1]\nepisodes: 1\n"


def a_run(folder, out, who, meet):
    run = colonysim.run("sanity", seed=who, episodes=2, out=out, record=("deposits", "frames"))
    return run.trace_sha256


def a_sweep(folder, out, who, meet):
    run_sweep(folder / "sweep.yaml", out, workers=1, on_outcome=meet)


def a_search(folder, out, who, meet):
    tune(folder / "search.yaml", out, workers=1, on_outcome=meet)


def a_reproduction(folder, out, who, meet):
    reproduce(out, ["hole-edge-case"], size=replace(QUICK, episodes=6, drawn=1), on_study=meet)


KINDS = {"run": a_run, "sweep": a_sweep, "search": a_search, "reproduction": a_reproduction}


def contend(kind, folder, who, tries, barrier, met, answers):
    """Tries as often; whoever has won goes on when the other has been refused (or has won too)."""
    for number in range(tries):
        waits = [True]

        def meet(*_, waits=waits):
            if waits:
                waits.pop()
                met.wait(60)

        out = folder / f"{kind}-{number}"
        if number % 2:
            out.mkdir(exist_ok=True)  # there, and empty
        barrier.wait(60)
        try:
            answer = True, KINDS[kind](folder, out, who, meet)
        except ColonysimError as error:
            answer = False, str(error)
        meet()
        answers.put((number, who, *answer))


def contest(kind: str, folder: Path, tries: int) -> list[list[tuple[bool, object]]]:
    """For each try what both processes came to: whether they had the directory, and a hash or a refusal."""
    (folder / "sweep.yaml").write_text(SWEEP)
    (folder / "search.yaml").write_text(SEARCH)
    context = multiprocessing.get_context("spawn")
    barrier, met, answers = context.Barrier(2), context.Barrier(2), context.Queue()
    make = partial(context.Process, target=contend)
    both = [make(args=(kind, folder, who, tries, barrier, met, answers)) for who in (1, 2)]
    for process in both:
        process.start()
    found: list[list[tuple[bool, object]]] = [[] for _ in range(tries)]
    for _ in range(2 * tries):
        number, _, won, said = answers.get(timeout=120)
        found[number].append((won, said))
    for process in both:
        process.join(60)
        assert process.exitcode == 0, sys.argv
    return found
