"""constraints.txt pins all that pyproject.toml asks for, and the README and CI install from it."""

import re
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
ASKED = [
    *PROJECT["build-system"]["requires"],
    *PROJECT["project"]["dependencies"],
    *(line for extra in PROJECT["project"]["optional-dependencies"].values() for line in extra),
]


def _pins() -> dict[str, list[str]]:
    pins: dict[str, list[str]] = {}
    for line in (ROOT / "constraints.txt").read_text().splitlines():
        if line and not line.startswith("#"):
            requirement = Requirement(line)
            (pin,) = requirement.specifier
            assert pin.operator == "==", line
            pins.setdefault(canonicalize_name(requirement.name), []).append(pin.version)
    return pins


@pytest.mark.parametrize("asked", sorted(set(ASKED)))
def test_every_requirement_is_pinned_to_a_version_that_it_allows(asked: str) -> None:
    requirement = Requirement(asked)
    if requirement.name == "colonysim":
        return
    versions = _pins().get(canonicalize_name(requirement.name))
    assert versions, f"{asked} is not in constraints.txt: run `just lock`"
    assert all(requirement.specifier.contains(version) for version in versions), f"{asked}: run `just lock`"


_MACHINES = [("linux", "x86_64"), ("linux", "aarch64"), ("win32", "AMD64"), ("win32", "ARM64"), ("darwin", "arm64"),
             ("darwin", "x86_64")]  # fmt: skip


def _brought(extra: str, python: str, system: str, machine: str) -> set[str]:
    """Names of the packages that an extra brings there."""
    there = {"python_version": python, "python_full_version": f"{python}.0", "sys_platform": system}
    there |= {"platform_machine": machine, "extra": ""}
    found = set()
    for line in PROJECT["project"]["optional-dependencies"][extra]:
        requirement = Requirement(line)
        if requirement.name == "colonysim":
            assert requirement.marker is None, f"{line}: hatchling drops the marker"
            found |= set().union(*(_brought(each, python, system, machine) for each in requirement.extras))
        elif requirement.marker is None or requirement.marker.evaluate(there):
            found.add(requirement.name)
    return found


@pytest.mark.parametrize("python", ["3.11", "3.12", "3.13", "3.14"])
@pytest.mark.parametrize(("system", "machine"), _MACHINES)
def test_the_extra_physics_brings_exactly_one_engine_everywhere(python: str, system: str, machine: str) -> None:
    engines = {"pybullet", "pybullet-arm64", "mujoco"}
    [engine] = _brought("physics", python, system, machine) & engines
    bullet = _brought("bullet", python, system, machine) & engines
    assert bullet <= {engine}
    wheels = (system, machine) in (("linux", "x86_64"), ("win32", "AMD64"), ("darwin", "arm64"))
    expected = {"3.11": "pybullet", "3.14": "mujoco"}.get(python, "pybullet-arm64" if wheels else "mujoco")
    assert engine == expected


def test_the_readme_installs_for_its_tests_from_it_and_ci_too() -> None:
    readme = (ROOT / "README.md").read_text()
    command = re.search(r"<!-- tests -->\n```sh\n(.*?)\n```", readme, re.DOTALL)
    assert command is not None
    assert "pip install -c constraints.txt -e '.[all,dev]'" in command[1]
    assert "PIP_CONSTRAINT=$PWD/constraints.txt" in (ROOT / ".ci" / "run").read_text()
