"""Parts that commands need named: extras to install, a rigid-body engine, code of others that no file imports."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Annotated, cast

import typer

from colonysim.engines import EngineName
from colonysim.errors import MissingExtraError
from colonysim.installing import install_command

__all__ = ["BackendOfOthers", "EngineOption", "PolicyOfOthers", "need", "need_engine"]

EngineOption = Annotated[
    EngineName | None,
    typer.Option("--engine", help="The rigid-body engine. [default: bullet where it is installed, else mujoco]"),
]

PolicyOfOthers = Annotated[
    str | None, typer.Option("--policy", "-p", help="The policy, if it is code of others: package.module:Name.")
]
BackendOfOthers = Annotated[
    str | None, typer.Option("--backend", "-b", help="The backend, if it is code of others: package.module:Name.")
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
