"""The results of a sweep as tables: one row a trial, one row an episode, in the order of the sweep's file."""

from __future__ import annotations

import json
import os
import time
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any

from colonysim.arguments import MAX_COUNT, MAX_SEED, as_span
from colonysim.errors import ColonysimError, MissingExtraError
from colonysim.files import LOCK, read_file, replacing
from colonysim.installing import install_command
from colonysim.intervals import of_mean
from colonysim.trace.checks import LONGEST
from colonysim.trace.fields import MOST

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from colonysim.sweep.plan import Trial

__all__ = [
    "BOUNDS", "COPY", "JOURNAL", "SHARDS", "STATE", "check_apart", "has_groups", "is_sweep", "query", "read_table",
    "read_tables", "settings", "summary", "write_tables",
]  # fmt: skip

JOURNAL, COPY, STATE = "journal.jsonl", "sweep.yaml", "state.npz"
"""Files of a sweep's directory: its journal, a copy of the file that it was run from, and of futures the colony."""
SHARDS = "shards"
"""Folder of a sweep's directory that holds those of its shards, each with a journal and tables of its own."""

_TEXT, _WHOLE, _NUMBER = ("string",), ("int64",), ("double", "int64")
_COLUMNS: dict[str, dict[str, tuple[str, ...]]] = {
    "trials": {
        "trial": _TEXT, "seed": _WHOLE, "status": _TEXT, "error": ("string", "null"), "episodes": _WHOLE,
        "success": ("double", "int64", "null"), "steps": ("double", "int64", "null"),
    },
    "episodes": {
        "trial": _TEXT, "episode": _WHOLE, "steps": _NUMBER, "success": _NUMBER, "ended": _TEXT, "sim_seconds": _NUMBER,
    },
    "groups": {
        "trial": _TEXT, "episode": _WHOLE, "group": _TEXT, "agents": _WHOLE, "success": _NUMBER, "steps": _NUMBER,
    },
}  # fmt: skip
"""Columns that every sweep has, and their types; the first is the usual one."""
BOUNDS = {
    "seed": (0, MAX_SEED), "episodes": (0, MAX_COUNT), "episode": (1, MAX_COUNT), "steps": (0, MOST), "success": (0, 1),
    "sim_seconds": (0, LONGEST), "seated": (0, MOST), "seconds": (0, LONGEST),
}  # fmt: skip
"""Least and largest number of columns that are counted and averaged, as those of a run."""
_PLAIN = ("string", "large_string", "int64", "double", "bool", "null")
_MOST_METADATA = 1_000_000
"""Longest text and list in the metadata of a table."""
_MOST_VALUES = 1000
"""Values for each byte of a table at most: settings repeat, and take next to nothing then."""
_BETWEEN = 0.5
"""Seconds of wall clock within which both tables are renewed."""

_OWN = (
    LOCK, JOURNAL, COPY, STATE, SHARDS, "trials.parquet", "episodes.parquet", "groups.parquet",
)  # fmt: skip
"""All that a sweep's directory may hold of its own."""
EPISODE = ("episode", "steps", "success", "ended", "sim_seconds", "seated")
GROUP = ("episode", "group", "agents", "success", "steps")


def write_tables(directory: Path, trials: Sequence[Trial], entries: Mapping[str, Mapping[str, Any]]) -> None:
    """Writes `trials.parquet` and `episodes.parquet`, each renamed into place; where there are any, `groups.parquet`.

    `seconds` is wall clock; all other columns are the same however often the sweep was stopped.

    Raises:
        ColonysimError: They cannot be written.
    """
    rows, episodes, groups = [], [], []
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
        groups += [{**about, **dict(zip(GROUP, group, strict=True))} for group in entry.get("groups", ())]
    _write(directory / "trials.parquet", rows)
    _write(directory / "episodes.parquet", episodes)
    if groups:
        _write(directory / "groups.parquet", groups)


def _mean(values: Sequence[float]) -> float | None:
    return sum(values) / len(values) if values else None


def _write(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = {name: _column([row[name] for row in rows]) for name in (rows[0] if rows else {"trial": None})}
    with replacing(path) as temporary, temporary.open("wb") as file:
        pq.write_table(pa.table(columns), file)


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
        name: "trials", "episodes" or "groups".

    Raises:
        ColonysimError: There is none, it is damaged, or a column is missing or of another type.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    path = Path(directory).absolute() / f"{name}.parquet"
    if not os.path.lexists(path):
        hint = ", but shards: `colonysim sweep --merge` joins them" if (path.parent / SHARDS).is_dir() else ""
        raise ColonysimError(f"{directory}: holds no results of a sweep{hint}")
    content = read_file(path)
    try:
        file = pq.ParquetFile(
            pa.BufferReader(content), page_checksum_verification=True, thrift_string_size_limit=_MOST_METADATA,
            thrift_container_size_limit=_MOST_METADATA,
        )  # fmt: skip
        about = file.metadata
        if about.num_rows * about.num_columns > _MOST_VALUES * len(content):
            raise ColonysimError(f"{path}: damaged, it claims {about.num_rows} rows in {len(content)} bytes")
        table = file.read(use_threads=False)
        table.validate(full=True)
    except (OSError, ValueError, TypeError, LookupError, ArithmeticError, MemoryError, pa.ArrowException) as error:
        told = (str(error).splitlines() or [type(error).__name__])[0]
        raise ColonysimError(f"{path}: cannot be read: {told[:200]}") from error
    _check(path, table, _COLUMNS[name])
    return table


def _check(path: Path, table: Any, expected: Mapping[str, tuple[str, ...]]) -> None:
    """Checks the columns that every sweep's table has, and that the others hold plain values."""
    import pyarrow.compute as pc

    names = table.column_names
    if names == ["trial"] and not table.num_rows:  # nothing has been played yet
        return
    if len(set(names)) < len(names):
        raise ColonysimError(f"{path}: two columns have the same name")
    for name, kinds in expected.items():
        if name not in names:
            raise ColonysimError(f"{path}: column {name!r} is missing")
        if str(table[name].type) not in kinds:
            raise ColonysimError(f"{path}: column {name!r} holds {table[name].type}, expected {kinds[0]}")
        if table[name].null_count and "null" not in kinds:
            raise ColonysimError(f"{path}: column {name!r} holds nulls")
        if str(table[name].type) == "double" and not pc.all(pc.is_finite(table[name]), min_count=0).as_py():
            raise ColonysimError(f"{path}: column {name!r} holds a value that is no finite number")
        if name in BOUNDS and table[name].null_count < len(table):
            least, most = BOUNDS[name]
            ends = pc.min_max(table[name]).as_py()
            odd = next((value for value in ends.values() if not least <= value <= most), None)
            if odd is not None:
                raise ColonysimError(f"{path}: column {name!r} holds {odd}, expected {least} to {most}")
    for name in names:
        if str(table[name].type) not in _PLAIN:
            raise ColonysimError(f"{path}: column {name!r} holds {table[name].type}, expected text, numbers or truth")
    if names[0] != "trial":
        raise ColonysimError(f"{path}: begins with column {names[0]!r}, expected 'trial'")


def read_tables(directory: str | Path) -> tuple[Any, Any]:
    """The tables of trials and episodes, that belong to each other.

    Raises:
        ColonysimError: There are none, one is damaged, or the episodes of a trial are not all there.
    """
    for last in (False, True):
        trials, episodes = read_table(directory, "trials"), read_table(directory, "episodes")
        found = Counter(episodes["trial"].to_pylist())
        told = dict(zip(*(trials[name].to_pylist() for name in ("trial", "episodes")), strict=True))
        wrong = [trial for trial in {**told, **found} if told.get(trial, -1) != found[trial]]
        if not wrong:
            break
        if last:
            raise ColonysimError(
                f"{directory}: episodes.parquet holds {found[wrong[0]]} episodes of the trial {wrong[0][:60]}, "
                f"trials.parquet tells of {told.get(wrong[0], 0)}"
            )
        time.sleep(_BETWEEN)  # a sweep under way renews one after the other
    return trials, episodes


def check_apart(directory: str | Path, out: str | Path) -> None:
    """Checks that a file which is to be written is none of a sweep's own.

    Raises:
        ColonysimError: It is.
    """
    try:
        within = Path(out).resolve().relative_to(Path(directory).resolve()).parts
    except (OSError, ValueError, RuntimeError):  # elsewhere, or no name of a file at all
        return
    if within and within[0] in _OWN:
        raise ColonysimError(f"{out}: is part of the sweep; write to another file")


def is_sweep(directory: str | Path) -> bool:
    """Whether a directory is one that `colonysim sweep`, `tune` or `fork` wrote to."""
    return any(os.path.lexists(Path(directory) / name) for name in ("trials.parquet", JOURNAL))


def has_groups(directory: str | Path) -> bool:
    """Whether a sweep has results by group."""
    return (Path(directory) / "groups.parquet").is_file()


def settings(trials: Any) -> list[str]:
    """The columns of the table of trials that tell what was run, without the seed."""
    return [name for name in trials.column_names[1 : trials.column_names.index("status")] if name != "seed"]


def summary(
    trials: Any, episodes: Any, by: Sequence[str] | None = None, only: tuple[int, int] | None = None
) -> list[dict[str, Any]]:
    """Means over the trials that differ in nothing but what is not in `by`, with 95 % intervals over them.

    By bootstrap from 8 trials on, Student's t for fewer, as for comparisons and tuning.

    Args:
        trials: The table of trials.
        episodes: The table of episodes.
        by: Columns to tell apart; None: those of the settings that vary.
        only: First and last episode that count; None for all.

    Returns:
        For each group its columns, how many `trials` it has, how many have `finished` or `failed`, and `success` and
        `steps` with `_low` and `_high`; None where none has finished, and of an interval where only one has.

    Raises:
        ColonysimError: There is no such column.
    """
    rows = trials.to_pylist()
    about = settings(trials)
    unknown = [name for name in by or () if name not in trials.column_names]
    if unknown:
        raise ColonysimError(f"no column {unknown[0]!r}; expected one of {', '.join([*about, 'seed'])}")
    if by is None:
        by = [name for name in about if len({row[name] for row in rows}) > 1] or about[:1]
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
            within = (0.0, 1.0) if name == "success" else None
            low, high = of_mean(values, within=within) or (None, None)
            line |= {name: _mean(values), f"{name}_low": low, f"{name}_high": high}
        found.append(line)
    return found


def query(directory: str | Path, sql: str) -> tuple[list[str], list[tuple[Any, ...]]]:
    """The answer of DuckDB to a query on `trials`, `episodes` and, if there are any, `groups`: columns, and rows.

    Raises:
        MissingExtraError: DuckDB is not installed.
        ColonysimError: The query is wrong.
    """
    try:
        import duckdb
    except ImportError as error:
        raise MissingExtraError(f"a query needs DuckDB ({error}): {install_command('sweep')}") from error
    tables = dict(zip(("trials", "episodes"), read_tables(directory), strict=True))
    if has_groups(directory):
        tables["groups"] = read_table(directory, "groups")
    # The query sees these tables, and neither files nor the network.
    with duckdb.connect(config={"enable_external_access": "false"}) as connection:
        for name, table in tables.items():
            connection.register(name, table)
        try:
            answer = connection.execute(sql)
            if answer is None:
                raise ColonysimError("--sql: holds no query")
            names = [column[0] for column in answer.description or ()]
            again = [name for name, count in Counter(names).items() if count > 1]
            if again:
                raise ColonysimError(f"--sql: two columns are called {again[0]!r}; name them apart with AS")
            return names, answer.fetchall()
        except (duckdb.Error, ValueError, OverflowError) as error:  # the latter of dates that Python has none for
            raise ColonysimError(f"--sql: {(str(error).splitlines() or ['cannot be answered'])[0]}") from None
