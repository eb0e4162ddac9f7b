"""The results of a sweep as tables: one row a trial, one row an episode, in the order of the sweep's file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from colonysim.arguments import MAX_COUNT, as_span
from colonysim.errors import ColonysimError, MissingExtraError
from colonysim.files import replacing
from colonysim.intervals import bootstrap

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from colonysim.sweep.plan import Trial

__all__ = ["query", "read_table", "summary", "write_tables"]

EPISODE = ("episode", "steps", "success", "ended", "sim_seconds", "seated")


def write_tables(directory: Path, trials: Sequence[Trial], entries: Mapping[str, Mapping[str, Any]]) -> None:
    """Writes `trials.parquet` and `episodes.parquet`, each renamed into place.

    `seconds` is wall clock; all other columns are the same however often the sweep was stopped.

    Raises:
        ColonysimError: They cannot be written.
    """
    rows, episodes = [], []
    columns = {name: None for trial in trials for name in trial.described()}
    for trial in trials:
        entry = entries.get(trial.identity, {"status": "pending"})
        about = {"trial": trial.identity, **columns, **trial.described()}
        played = entry.get("episodes", ())
        rows.append({
            **about, "status": entry["status"], "error": entry.get("error"), "episodes": len(played),
            "success": _mean([episode[2] for episode in played]), "steps": _mean([episode[1] for episode in played]),
            "trace_sha256": entry.get("trace_sha256"), "seconds": entry.get("seconds"),
        })  # fmt: skip
        episodes += [{**about, **dict(zip(EPISODE, episode, strict=True))} for episode in played]
    _write(directory / "trials.parquet", rows)
    _write(directory / "episodes.parquet", episodes)


def _mean(values: Sequence[float]) -> float | None:
    return sum(values) / len(values) if values else None


def _write(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = {name: _column([row[name] for row in rows]) for name in (rows[0] if rows else {"trial": None})}
    with replacing(path) as temporary:
        pq.write_table(pa.table(columns), temporary)


def _column(values: Sequence[Any]) -> list[Any]:
    """Values of one type; what is mixed or nested becomes JSON text."""
    kinds = {type(value) for value in values if value is not None}
    if kinds <= {int, float}:
        return [float(value) if float in kinds and value is not None else value for value in values]
    if len(kinds) == 1 and kinds <= {str, bool}:
        return list(values)
    return [value if value is None else json.dumps(value, sort_keys=True) for value in values]


def read_table(directory: str | Path, name: str) -> Any:
    """A table of a sweep's directory, as a `pyarrow.Table`.

    Args:
        directory: The sweep's.
        name: "trials" or "episodes".

    Raises:
        ColonysimError: There is none, or it is damaged.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    path = Path(directory) / f"{name}.parquet"
    if not path.is_file():
        raise ColonysimError(f"{directory}: holds no results of a sweep")
    try:
        return pq.read_table(path)
    except (OSError, pa.ArrowException) as error:
        raise ColonysimError(f"{path}: cannot be read: {str(error).splitlines()[0]}") from error


def summary(
    trials: Any, episodes: Any, by: Sequence[str] | None = None, only: tuple[int, int] | None = None
) -> list[dict[str, Any]]:
    """Means over the trials that differ in nothing but what is not in `by`, with 95 % bootstrap intervals.

    Args:
        trials: The table of trials.
        episodes: The table of episodes.
        by: Columns to tell apart; None: those of the settings that vary.
        only: First and last episode that count; None for all.

    Returns:
        For each group its columns, how many `trials` it has, how many have `finished` or `failed`, and `success` and
        `steps` with `_low` and `_high`; None where none has finished.

    Raises:
        ColonysimError: There is no such column.
    """
    rows = trials.to_pylist()
    settings = [name for name in trials.column_names[1 : trials.column_names.index("status")] if name != "seed"]
    unknown = [name for name in by or () if name not in trials.column_names]
    if unknown:
        raise ColonysimError(f"no column {unknown[0]!r}; expected one of {', '.join([*settings, 'seed'])}")
    if by is None:
        by = [name for name in settings if len({row[name] for row in rows}) > 1] or settings[:1]
    first, last = (1, MAX_COUNT) if only is None else as_span("episodes", only)
    played: dict[str, list[dict[str, Any]]] = {}
    for episode in episodes.to_pylist():
        if first <= episode["episode"] <= last:
            played.setdefault(episode["trial"], []).append(episode)
    groups: dict[tuple[Any, ...], list[dict[str, Any]]] = {}
    for row in rows:
        groups.setdefault(tuple(row[name] for name in by), []).append(row)
    found = []
    for key, members in groups.items():
        statuses = [row["status"] for row in members]
        line = {
            **dict(zip(by, key, strict=True)), "trials": len(members), "finished": statuses.count("succeeded"),
            "failed": statuses.count("failed"),
        }  # fmt: skip
        for name in ("success", "steps"):
            means = [_mean([e[name] for e in played[row["trial"]]]) for row in members if row["trial"] in played]
            values = [mean for mean in means if mean is not None]
            low, high = bootstrap(values) if values else (None, None)
            line |= {name: _mean(values), f"{name}_low": low, f"{name}_high": high}
        found.append(line)
    return found


def query(directory: str | Path, sql: str) -> tuple[list[str], list[tuple[Any, ...]]]:
    """The answer of DuckDB to a query on the tables `trials` and `episodes`: names of the columns, and rows.

    Raises:
        MissingExtraError: DuckDB is not installed.
        ColonysimError: The query is wrong.
    """
    try:
        import duckdb
    except ImportError as error:
        raise MissingExtraError(f"a query needs DuckDB ({error}): pip install 'colonysim[sweep]'") from error
    tables = {name: read_table(directory, name) for name in ("trials", "episodes")}
    # The query sees these two tables, and neither files nor the network.
    with duckdb.connect(config={"enable_external_access": "false"}) as connection:
        for name, table in tables.items():
            connection.register(name, table)
        try:
            answer = connection.execute(sql)
            return [column[0] for column in answer.description or ()], answer.fetchall()
        except duckdb.Error as error:
            raise ColonysimError(f"--sql: {str(error).splitlines()[0]}") from None
