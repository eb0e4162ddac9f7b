"""How the work is shared among the agents."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from matplotlib.ticker import MaxNLocator

from colonysim.plots.paper import AGENT, BOX, INK, plain, title_of
from colonysim.plots.sheet import SCREEN, EmptyFigureError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

    from colonysim.plots.sheet import Sheet
    from colonysim.scenario.groups import Group
    from colonysim.trace.reader import Run

__all__ = ["gini", "workload_figure"]

_ACTIONS = (("travel", "travels", AGENT), ("take", "goes to a box", "#56B4E9"), ("push", "pushes", BOX))


def gini(values: Sequence[float]) -> float:
    """The Gini coefficient of a share: 0 if all have the same, up to 1 - 1/n if one has it all; 0 if nobody has any.

    Example:
        >>> gini([2, 2, 2]), gini([0, 0, 6])
        (0.0, 0.6666666666666666)
    """
    whole, count = sum(values), len(values)
    if not whole:
        return 0.0
    ranked = sum((2 * i - count + 1) * value for i, value in enumerate(sorted(values)))
    return ranked / (count * whole)


def workload_figure(run: Run, group: Group | None = None, sheet: Sheet = SCREEN) -> Figure:
    """The steps of each agent by what they were for; beside it, how evenly they are shared, by episode.

    Args:
        run: The run.
        group: The agents that count; None for all.
        sheet: What it is drawn on.

    Raises:
        EmptyFigureError: No agent began a step.
    """
    agents = range(len(run.scenario.agents)) if group is None else group.agents
    numbers = [result.episode for result in run.episodes]
    steps: Counter[tuple[int, int, str]] = Counter(
        (event.episode, event.agent, event.action) for event in run.events() if event.kind == "end"
    )
    if not any(agent in agents for _, agent, _ in steps):
        raise EmptyFigureError("no agent ended a step")
    totals: Counter[tuple[int, str]] = Counter()
    for (_, agent, action), count in steps.items():
        totals[agent, action] += count
    rows, columns = sheet.beside(2)
    figure = sheet.figure(4.2 * columns, (2.6 if sheet.narrow else 3.6) * rows, title_of("Workload", run, group))
    left, right = figure.subplots(rows, columns)
    bottom = [0.0] * len(agents)
    for action, label, color in _ACTIONS:
        heights = [totals[agent, action] / len(numbers) for agent in agents]
        left.bar(agents, heights, bottom=bottom, color=color, label=label, width=0.75)
        bottom = [low + height for low, height in zip(bottom, heights, strict=True)]
    names = [action for action, _, _ in _ACTIONS]
    every = gini([sum(totals[agent, name] for name in names) for agent in agents])
    pushes = gini([totals[agent, "push"] for agent in agents])
    plain(left, "agent", "steps in an episode, mean", f"Gini coefficient: steps {every:.2f}, pushes {pushes:.2f}")
    left.set_xlim(agents.start - 0.7, agents.stop - 0.3)
    left.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    left.set_ylim(0, 1.25 * max(*bottom, 1.0))
    for label, color, chosen in (("steps", INK, names), ("pushes", BOX, ["push"])):
        shares = [
            gini([sum(steps[number, agent, name] for name in chosen) for agent in agents]) for number in numbers
        ]  # fmt: skip
        right.plot(numbers, shares, ".-", color=color, markersize=5, linewidth=1.2, label=label)
    plain(right, "episode", "Gini coefficient [0: all alike]", "by episode")
    right.set(xlim=(numbers[0] - 0.5, numbers[-1] + 0.5), ylim=(-0.03, 1.03))
    right.xaxis.set_major_locator(MaxNLocator(integer=True))
    # The two diagrams give "pushes" colours of their own: each keeps its legend, above its data.
    left.legend(fontsize=7, frameon=False, ncols=3, loc="upper right")
    right.legend(fontsize=7, frameon=False, ncols=2, loc="upper right")
    right.set_ylim(-0.03, 1.18)
    return figure
