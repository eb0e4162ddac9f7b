"""The results of a run, as JSON and as a table."""

from __future__ import annotations

from statistics import fmean, stdev
from typing import TYPE_CHECKING, Any

from colonysim.cli.console import print_result, print_table
from colonysim.files import shown_path

if TYPE_CHECKING:
    from collections.abc import Sequence

    from colonysim.trace.groups import GroupResult
    from colonysim.trace.reader import Run
    from colonysim.trace.schema import EpisodeResult

__all__ = ["by_group", "episode_line", "print_groups", "print_results", "results"]


def _spread(values: Sequence[float]) -> tuple[float, float]:
    """Mean and sample standard deviation (0 for a single value)."""
    return (fmean(values), stdev(values) if len(values) > 1 else 0.0) if values else (0.0, 0.0)


def episode_line(result: EpisodeResult) -> str:
    """One episode in a line, as it is told while a run goes on."""
    return (
        f"episode {result.episode:3d}: {result.steps:3d} steps, success {result.success:.2f}, "
        f"{result.ended}, {result.sim_seconds:.1f} s simulated in {result.wall_seconds:.1f} s"
    )


def results(run: Run) -> dict[str, Any]:
    """What `colonysim run --json` prints; standard deviations are those of a sample (n - 1)."""
    steps_mean, steps_sd = _spread([episode.steps for episode in run.episodes])
    success_mean, success_sd = _spread([episode.success for episode in run.episodes])
    keys = ("episode", "steps", "success", "ended", "sim_seconds", "wall_seconds")
    return {
        "scenario": run.manifest["name"],
        "backend": run.manifest["backend"],
        "policy": run.manifest["policy"],
        "mode": run.manifest["mode"],
        "seed": run.manifest["seed"],
        "out": None if run.path is None else shown_path(run.path),
        "trace_sha256": run.trace_sha256,
        **({"groups": by_group(run.groups)} if run.groups else {}),
        "episodes": [{key: getattr(episode, key) for key in keys} for episode in run.episodes],
        "summary": {
            "steps_mean": steps_mean,
            "steps_sd": steps_sd,
            "success_mean": success_mean,
            "success_sd": success_sd,
        },
    }


def print_results(run: Run) -> None:
    """The same as a table for people: all episodes, and the last third if there are many."""
    from collections import Counter

    episodes = run.episodes
    parts = [episodes]
    if len(episodes) >= 9:
        third = len(episodes) // 3
        parts += [episodes[:third], episodes[-third:]]
    rows = []
    for part in parts:
        if part:
            rows.append(_row(part, Counter(episode.ended for episode in part)))
    manifest = run.manifest
    title = f"{manifest['name']} · {manifest['backend']} · {manifest['policy']} · {manifest['mode']}"
    columns = ("episodes", ">steps", ">success", ">simulated s", ">wall s", "ended")
    print_table(columns, rows, f"{title} · seed {manifest['seed']}")
    print_groups(run.groups)
    if engine := manifest.get("engine"):
        print_result(f"engine {engine['version']}")
    if run.path is not None:
        print_result(f"run    {shown_path(run.path)}")
    print_result(f"trace  {run.trace_sha256}")


def by_group(results: Sequence[GroupResult]) -> list[dict[str, Any]]:
    """Means over the episodes for each group of agents."""
    found = []
    for name in dict.fromkeys(result.group for result in results):
        own = [result for result in results if result.group == name]
        steps, success = _spread([result.steps for result in own]), _spread([result.success for result in own])
        found.append({
            "group": name, "agents": own[0].agents, "episodes": len(own), "steps_mean": steps[0], "steps_sd": steps[1],
            "success_mean": success[0], "success_sd": success[1],
        })  # fmt: skip
    return found


def print_groups(results: Sequence[GroupResult]) -> None:
    """The same as a table for people; nothing if there are no groups."""
    rows = [
        (
            group["group"],
            str(group["agents"]),
            f"{group['steps_mean']:.2f} ± {group['steps_sd']:.2f}",
            f"{group['success_mean']:.3f} ± {group['success_sd']:.3f}",
        )
        for group in by_group(results)
    ]
    if rows:
        print_table(("group", ">agents", ">steps", ">success"), rows)


def _row(part: Sequence[EpisodeResult], endings: dict[str, int]) -> tuple[str, ...]:
    steps, steps_sd = _spread([episode.steps for episode in part])
    success, success_sd = _spread([episode.success for episode in part])
    return (
        f"{part[0].episode}-{part[-1].episode}" if len(part) > 1 else str(part[0].episode),
        f"{steps:.2f} ± {steps_sd:.2f}",
        f"{success:.3f} ± {success_sd:.3f}",
        f"{fmean(episode.sim_seconds for episode in part):.1f}",
        f"{sum(episode.wall_seconds for episode in part):.1f}",
        ", ".join(f"{ended} {count}" for ended, count in sorted(endings.items())),
    )
