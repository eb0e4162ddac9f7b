"""Compiles the hot modules with Cython, where there is a C compiler; without one everything runs as plain Python.

COLONYSIM_COMPILE=0 leaves them uncompiled, COLONYSIM_COMPILE=1 makes it an error if that fails.
"""

from __future__ import annotations

import json
import os
import runpy
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

HOT = (
    "colonysim/backends/action.py",
    "colonysim/backends/motion.py",
    "colonysim/backends/nodeworld.py",
    "colonysim/backends/physics.py",
    "colonysim/backends/traffic.py",
    "colonysim/draws.py",
    "colonysim/exact.py",
    "colonysim/pheromones/box.py",
    "colonysim/pheromones/distance.py",
    "colonysim/pheromones/exploration.py",
    "colonysim/pheromones/field.py",
    "colonysim/pheromones/hole.py",
    "colonysim/pheromones/marks.py",
    "colonysim/pheromones/spreading.py",
    "colonysim/physics/bullet.py",
    "colonysim/physics/mujoco.py",
    "colonysim/physics/scene.py",
    "colonysim/physics/shapes.py",
    "colonysim/physics/traction.py",
    "colonysim/policies/choice.py",
    "colonysim/policies/presets.py",
    "colonysim/policies/stigmergy.py",
    "colonysim/policies/decision.py",
    "colonysim/policies/sensing.py",
    "colonysim/policies/view.py",
    "colonysim/push/controls.py",
    "colonysim/push/driving.py",
    "colonysim/push/footing.py",
    "colonysim/push/learned.py",
    "colonysim/push/paths.py",
    "colonysim/push/staging.py",
    "colonysim/push/state.py",
    "colonysim/rl/sight.py",
    "colonysim/simulation/alarms.py",
    "colonysim/simulation/clock.py",
    "colonysim/simulation/episode.py",
    "colonysim/simulation/waiting.py",
    "colonysim/trace/block.pyx",
    "colonysim/trace/rows.py",
    "colonysim/trace/writer.py",
    "colonysim/world/neighbourhoods.py",
    "colonysim/world/visibility.py",
    "colonysim/world/state.py",
    "colonysim/world/terrain.py",
)

FLAGS = ("-g0", "-w", "-Wno-all", "-ffp-contract=off")
"""Contracted multiply-adds round differently, and traces have to be the same everywhere. `-w` alone hides warnings that
are still searched for, which takes a seventh of the compiler's time."""

LEVEL = (
    "-O1", "-falign-functions", "-falign-jumps", "-falign-loops", "-fcode-hoisting", "-foptimize-sibling-calls",
    "-freorder-blocks", "-fstrict-aliasing",
)  # fmt: skip
"""The first level of optimisation and what brings most of the second: a colony on `hard` then takes 5 % more
instructions than with the second, and compiling two thirds of its time."""
SELDOM = (
    "colonysim/policies/presets.py",
    "colonysim/policies/sensing.py",
    "colonysim/push/controls.py",
    "colonysim/push/paths.py",
    "colonysim/push/staging.py",
    "colonysim/push/state.py",
    "colonysim/simulation/clock.py",
)
"""Each runs for at most a 400th of an episode on Bullet, by sampling, and of others not at all, unless their sensors
err: compiled in half the time."""

RECORD = "colonysim/compiled.json"
"""What was compiled of which sources, or why nothing was; `colonysim/built.py` reads it."""
SHARED = "colonysim._cython"
"""What Cython needs in every module, such as typed views of arrays, is compiled once and shared."""

DIRECTIVES = {"language_level": 3, "annotation_typing": False, "binding": False, "emit_code_comments": False}


def compile_hot(root: Path, scratch: Path) -> list[Path]:
    """Compiles `HOT` below `root`; returns the extension modules, each beside its source."""
    from Cython.Build import cythonize
    from setuptools import Distribution, Extension
    from setuptools.command.build_ext import build_ext

    def flags(name: str) -> list[str]:
        level = ("-Og",) if name in SELDOM else LEVEL
        return [] if sys.platform == "win32" else [*level, *FLAGS]

    extensions = [
        Extension(
            str(Path(name).with_suffix("")).replace(os.sep, "."),
            [name],
            extra_compile_args=flags(name),
        )
        for name in HOT
    ]
    before = Path.cwd()
    os.chdir(root)
    try:
        shared = scratch / f"{SHARED.rpartition('.')[2]}.c"
        subprocess.run([sys.executable, "-m", "cython", f"--generate-shared={shared}"], check=True)
        made = cythonize(
            extensions,
            compiler_directives=DIRECTIVES,
            build_dir=str(scratch),
            quiet=True,
            nthreads=os.cpu_count() or 1,
            shared_utility_qualified_name=SHARED,
        )
        made.append(Extension(SHARED, [str(shared)], extra_compile_args=flags(SHARED)))
        command = build_ext(Distribution({"name": "colonysim", "ext_modules": made}))
        command.parallel = os.cpu_count()
        command.build_lib, command.build_temp = str(scratch / "lib"), str(scratch / "temp")
        command.ensure_finalized()
        command.run()
    finally:
        os.chdir(before)
    placed = []
    for built in sorted((scratch / "lib").rglob("*.*")):
        target = root / built.relative_to(scratch / "lib")
        # Not over the old one: a program that runs on it would crash.
        fresh = target.with_suffix(f".{os.getpid()}")
        shutil.copy2(built, fresh)
        fresh.replace(target)
        placed.append(target)
    record = root / RECORD
    sources = {Path(name).with_suffix("").relative_to("colonysim").as_posix(): root / name for name in HOT}
    # Not imported: the package itself is not installed yet.
    digest = runpy.run_path(str(root / "colonysim" / "built.py"))["digest"]
    record.write_text(json.dumps({name: digest(source) for name, source in sources.items()}, indent=1))
    return [*placed, record]


class CompileHook(BuildHookInterface[Any]):
    """Hatchling's hook: runs before a wheel, or an editable installation, is put together."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compiles and adds the result to the wheel."""
        wish = os.environ.get("COLONYSIM_COMPILE", "")
        if self.target_name != "wheel" or wish == "0":
            return
        root = Path(self.root)
        try:
            with tempfile.TemporaryDirectory() as scratch:
                placed = compile_hot(root, Path(scratch))
        except BaseException as error:  # setuptools ends with SystemExit where there is no compiler
            if wish == "1" or isinstance(error, KeyboardInterrupt):
                raise
            # pip shows this only when asked to; `colonysim --version`, `backends` and every run's manifest say it too.
            self.app.display_warning(f"colonysim runs as plain Python, its hot modules were not compiled: {error}")
            why = str(error).strip().partition("\n")[0][:200] or repr(error)
            (root / RECORD).write_text(json.dumps({"failed": why}))
            build_data["artifacts"] += [f"/{RECORD}"]
            return
        build_data["pure_python"] = False
        build_data["infer_tag"] = True
        build_data["artifacts"] += [f"/{path.relative_to(root).as_posix()}" for path in placed]
