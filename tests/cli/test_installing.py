"""Messages name the command that installs what is missing from where the package came."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

import pytest

from colonysim import installing

ROOT = Path(installing.__file__).parents[1]


@pytest.fixture(autouse=True)
def activated(monkeypatch: pytest.MonkeyPatch) -> None:
    """The environment of this interpreter is activated, so that `pip` is its own."""
    monkeypatch.setenv("VIRTUAL_ENV", sys.prefix)


@pytest.mark.skipif(sys.prefix == sys.base_prefix, reason="not in a virtual environment")
def test_without_an_activated_environment_pip_is_this_interpreter_s(monkeypatch: pytest.MonkeyPatch) -> None:
    for other in (None, "/somewhere/else"):
        if other is None:
            monkeypatch.delenv("VIRTUAL_ENV")
        else:
            monkeypatch.setenv("VIRTUAL_ENV", other)
        monkeypatch.chdir(ROOT)
        python, *rest = shlex.split(installing.install_command("plot"))
        assert Path(ROOT, python) == Path(sys.executable) and rest == ["-m", "pip", "install", ".[plot]"]


@pytest.fixture
def elsewhere(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """The package as if it lay in a folder for packages; returns a checkout."""
    monkeypatch.setattr(installing, "__file__", str(tmp_path / "site-packages" / "colonysim" / "installing.py"))
    checkout = tmp_path / "my checkout"
    checkout.mkdir()
    (checkout / "hatch_build.py").touch()
    return checkout


def told(monkeypatch: pytest.MonkeyPatch, **found: object) -> None:
    monkeypatch.setattr(installing, "_told", lambda: found)


def test_in_a_checkout_it_is_that_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(ROOT)
    assert shlex.split(installing.install_command("plot")) == ["pip", "install", ".[plot]"]
    monkeypatch.chdir(tmp_path)
    assert shlex.split(installing.install_command("plot")) == ["pip", "install", f"{ROOT}[plot]"]


def test_a_package_from_a_checkout_is_installed_from_there(monkeypatch: pytest.MonkeyPatch, elsewhere: Path) -> None:
    told(monkeypatch, url=elsewhere.as_uri(), dir_info={})
    assert shlex.split(installing.install_command("rl")) == ["pip", "install", f"{elsewhere}[rl]"]
    again = shlex.split(installing.compile_command())
    assert again == ["COLONYSIM_COMPILE=1", "pip", "install", "--force-reinstall", "--no-deps", str(elsewhere)]
    told(monkeypatch, url=elsewhere.as_uri(), dir_info={"editable": True})
    assert shlex.split(installing.compile_command())[-2:] == ["-e", str(elsewhere)]


@pytest.mark.parametrize(
    ("found", "what"),
    [
        ({}, "colonysim[rl]"),
        ({"url": "file:///nowhere/at/all", "dir_info": {}}, "colonysim[rl]"),
        ({"url": "https://a.org/b.git", "vcs_info": {"vcs": "git"}}, "colonysim[rl] @ git+https://a.org/b.git"),
    ],
)
def test_any_other_is_installed_by_its_name(
    monkeypatch: pytest.MonkeyPatch, elsewhere: Path, found: dict[str, object], what: str
) -> None:
    told(monkeypatch, **found)
    assert shlex.split(installing.install_command("rl")) == ["pip", "install", what]
