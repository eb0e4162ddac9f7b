"""Whatever policies, backends and fields of others do: no traceback, no hang, and the interpreter lives."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import faulty_parts
import pytest

COUNTS = {"policies": 200, "backends": 100, "fields": 50}
WHOSE = re.compile(r"(policy|backend|field|what was given as|the backend wrote)\b")


@pytest.mark.parametrize("kind", COUNTS)
def test_a_faulty_part_is_one_error_or_runs_well(kind):
    found = [faulty_parts.tried(kind, seed) for seed in range(COUNTS[kind] // 8)]
    wrong = [said for said in found if said != "fine"]
    assert len(wrong) > len(found) // 3 and all(WHOSE.match(said) for said in wrong)


@pytest.mark.slow
@pytest.mark.parametrize("kind", COUNTS)
def test_many_faulty_parts_end_within_seconds_and_kill_nobody(kind):
    program = [sys.executable, "-X", "faulthandler", faulty_parts.__file__, kind, "0", str(COUNTS[kind])]
    done = subprocess.run(program, capture_output=True, text=True, timeout=1800, cwd=Path(__file__).parent)
    assert (done.returncode, done.stderr) == (0, ""), done.stdout[-200:] + done.stderr[-2000:]
    lines = [line.split(" ", 2) for line in done.stdout.splitlines()]
    assert len(lines) == COUNTS[kind]
    assert max(float(seconds) for _, seconds, _ in lines) < 10.0
    assert all(said == "fine" or WHOSE.match(said) for _, _, said in lines)
    wrong = sum(said != "fine" for _, _, said in lines)
    print(f"{kind}: {COUNTS[kind]} tried, {wrong} refused, longest {max(float(s) for _, s, _ in lines):.2f} s")
