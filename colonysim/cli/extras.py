"""What to install when an optional part is missing, and which rigid-body engine a command uses."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Annotated, cast

import typer

from colonysim.engines import EngineName
from colonysim.errors import MissingExtraError
from colonysim.installing import install_command

__all__ = ["EngineOption", "need", "need_engine"]

EngineOption = Annotated[
    EngineName | None,
    typer.Option("--engine", help="The rigid-body engine. [default: bullet where it is installed, else mujoco]"),
]


def need(package: str, extra: str, purpose: str) -> None:
    """Checks that an optional package is installed.

    Raises:
        MissingExtraError: It is not; the message holds the command that installs it.
    """
    if find_spec(package) is None:
        raise MissingExtraError(f"{purpose} needs {package}, which is not installed: {install_command(extra)}")


def need_engine(asked: str | None) -> EngineName:
    """The rigid-body engine that is asked for, by default the first that is installed.

    Raises:
        MissingExtraError: It is not installed, perhaps because it has no wheel for this Python.
    """
    from colonysim.physics import default_engine, engine_trouble

    name = asked or default_engine()
    if trouble := engine_trouble(name):
        raise MissingExtraError(trouble)
    return cast("EngineName", name)
