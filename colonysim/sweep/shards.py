"""Shards: the n parts of a sweep that n commands run without knowing of each other, joined by `merge_shards`.

Trial k of a sweep, counted from 0 in the order of its file, belongs to shard k modulo n, so that neighbours, which
mostly differ by their seed, come to different shards. Each shard writes in a directory of its own and nowhere else: on
a file system that many machines share, none needs a lock against the others.
"""

from __future__ import annotations

import hashlib
import json
import re
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from colonysim import __version__
from colonysim.arguments import shown, whole
from colonysim.errors import ColonysimError, ColonysimWarning
from colonysim.files import read_json, replace_file
from colonysim.sweep.plan import MAX_TRIALS
from colonysim.sweep.store import holds_sweep
from colonysim.sweep.tables import SHARDS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from colonysim.sweep.plan import Sweep, Trial

__all__ = ["Shard", "as_shard", "begin_shard", "difference", "refuse_unmerged", "shards_of"]

_RECORD = "shard.json"
"""What a shard was planned from, in its directory."""


@dataclass(frozen=True, order=True)
class Shard:
    """One part of a sweep.

    Attributes:
        number: Which one, from 1.
        count: Of how many.
    """

    number: int
    count: int

    def __str__(self) -> str:
        """As it is given on the command line: "2/8"."""
        return f"{self.number}/{self.count}"

    def directory(self, out: str | Path) -> Path:
        """Where it writes, within the sweep's directory `out`."""
        return Path(out) / SHARDS / f"{self.number}-of-{self.count}"

    def of(self, trials: Sequence[Trial]) -> Sequence[Trial]:
        """Its trials among all of a sweep."""
        return trials[self.number - 1 :: self.count]


def as_shard(value: Any) -> Shard:
    """A shard from "2/8" or (2, 8).

    Raises:
        ColonysimError: It is neither, or there is no such part.
    """
    words = re.fullmatch(r"([0-9]{1,7})/([0-9]{1,7})", value) if isinstance(value, str) else None
    try:
        count = whole("shard", int(words[2]) if words else value[1], 1, MAX_TRIALS)
        number = whole("shard", int(words[1]) if words else value[0], 1, count)
        if words or len(value) == 2:
            return Shard(number, count)
    except (TypeError, LookupError, ColonysimError):
        pass
    raise ColonysimError(f"shard {shown(value)}: expected the number of a part and how many there are, such as 2/8")


def shards_of(out: str | Path, beginning: Shard | None = None) -> list[Shard]:
    """The shards that have been begun in a sweep's directory, in their order.

    Args:
        out: The sweep's directory.
        beginning: One that is about to be begun there.

    Raises:
        ColonysimError: They are parts of different divisions.
    """
    folder = Path(out) / SHARDS
    names = [re.fullmatch(r"([1-9][0-9]{0,6})-of-([1-9][0-9]{0,6})", path.name) for path in folder.glob("*")]
    found = sorted(Shard(int(name[1]), int(name[2])) for name in names if name)
    counts = sorted({shard.count for shard in [*found, *([beginning] if beginning else [])]})
    if len(counts) > 1:
        raise ColonysimError(
            f"{folder}: shards of {' and of '.join(map(str, counts))}, expected those of one division: merge and "
            "remove what is there, or choose another directory"
        )
    return found


def begin_shard(shard: Shard, planned: Sweep, out: str | Path) -> None:
    """Records what a shard is planned from, and warns of others that were planned from something else.

    Args:
        shard: Which one; this process holds its directory.
        planned: All trials of the sweep.
        out: The sweep's directory.

    Raises:
        ColonysimError: The record cannot be written.
    """
    replace_file(shard.directory(out) / _RECORD, json.dumps(_record(planned), indent=1) + "\n")
    others = [str(other) for other in shards_of(out) if other != shard and difference(other, planned, out)]
    if others:
        warnings.warn(
            f"{out}: shard {', '.join(others)} ran another version of the file, of its scenarios, of code or of "
            "colonysim; run these again before you merge", ColonysimWarning, stacklevel=3,
        )  # fmt: skip


def difference(shard: Shard, planned: Sweep, out: str | Path) -> str:
    """In what a shard's plan differs from a sweep's as it is now, in words; "" if it is the same.

    Raises:
        ColonysimError: The shard's record is damaged.
    """
    path = shard.directory(out) / _RECORD
    if not path.exists():
        return ""  # it was killed before it began anything
    there, now = read_json(path), _record(planned)
    if there == now:
        return ""
    if not isinstance(there, dict) or there.keys() != now.keys():
        raise ColonysimError(f"{path}: is not as it was written; run the shard {shard} again")
    if there["version"] != now["version"]:
        return f"was run by colonysim {there['version']}, this is {now['version']}"
    if there["trials"] != now["trials"]:
        return f"ran a file of {there['trials']} trials, this one has {now['trials']}"
    return "ran another version of the file, of its scenarios or of code"


def _record(planned: Sweep) -> dict[str, Any]:
    identities = "\n".join(trial.identity for trial in planned.trials)
    plan = hashlib.sha256(identities.encode()).hexdigest()
    return {"version": __version__, "trials": len(planned.trials), "plan": plan}


def refuse_unmerged(out: str | Path) -> None:
    """Refuses to run all trials of a sweep where shards hold some that have not been merged.

    Raises:
        ColonysimError: They do.
    """
    if (Path(out) / SHARDS).is_dir() and not holds_sweep(out):
        raise ColonysimError(f"{out}: holds shards; --shard goes on with one of them, --merge joins them")
