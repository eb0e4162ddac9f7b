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


def test_the_readme_installs_for_its_tests_from_it_and_ci_too() -> None:
    readme = (ROOT / "README.md").read_text()
    command = re.search(r"<!-- tests -->\n```sh\n(.*?)\n```", readme, re.DOTALL)
    assert command is not None
    assert "pip install -c constraints.txt -e '.[all,dev]'" in command[1]
    assert "PIP_CONSTRAINT=$PWD/constraints.txt" in (ROOT / ".ci" / "run").read_text()
