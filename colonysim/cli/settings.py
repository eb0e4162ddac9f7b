"""`--set KEY=VALUE` for the parameters of a training."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any, TypeVar, get_type_hints

from colonysim.errors import ColonysimError
from colonysim.suggest import nearest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from colonysim.push.training.presets import TrainingConfig

    Config = TypeVar("Config")

__all__ = ["with_push_settings", "with_settings"]

_AT_LEAST_ONE = ("steps", "buffer", "batch", "update_every", "train_block", "test_block", "score_blocks", "candidates")


def with_push_settings(config: TrainingConfig, settings: Sequence[str]) -> TrainingConfig:
    """A configuration of the push's training with some of its parameters set.

    Args:
        config: The configuration.
        settings: As for `with_settings`.

    Raises:
        ColonysimError: No such parameter, a value that does not fit, or a training that would never end.
    """
    config = with_settings(config, settings)
    if config.actions is None and config.episodes is None:
        raise ColonysimError("--set: neither actions nor episodes has a limit, so the training would never end")
    for name in _AT_LEAST_ONE:
        if getattr(config, name) < 1:
            raise ColonysimError(f"--set: {name} is {getattr(config, name)}, expected at least 1")
    return config


def with_settings(config: Config, settings: Sequence[str]) -> Config:
    """A configuration with some of its parameters set.

    Args:
        config: The configuration, a dataclass.
        settings: Such as "actions=300", "learner.loss=squared" or "hidden=[64, 64]": the text after "=" is YAML.

    Raises:
        ColonysimError: No such parameter, or a value that does not fit.
    """
    for text in settings:
        key, found, value = text.partition("=")
        if not found:
            raise ColonysimError(f"--set {text!r}: expected KEY=VALUE, such as actions=300")
        config = _with(config, key.strip().split("."), value, text)
    return config


def _with(part: Any, keys: list[str], value: str, text: str) -> Any:
    if keys == ["engine"]:
        raise ColonysimError(f"--set {text!r}: the engine has an option of its own, --engine")
    known = [field.name for field in dataclasses.fields(part) if field.name not in ("name", "engine")]
    if keys[0] not in known:
        raise ColonysimError(f"--set {text!r}: no parameter {keys[0]!r}; {nearest(keys[0], known)}")
    inner = getattr(part, keys[0])
    if dataclasses.is_dataclass(inner):
        if len(keys) == 1:
            names = ", ".join(f"{keys[0]}.{field.name}" for field in dataclasses.fields(inner))
            raise ColonysimError(f"--set {text!r}: {keys[0]!r} has parts; set one of: {names}")
        changed = _with(inner, keys[1:], value, text)
    elif len(keys) > 1:
        raise ColonysimError(f"--set {text!r}: {keys[0]!r} has no parts")
    else:
        changed = _read(get_type_hints(type(part))[keys[0]], value, text)
    return dataclasses.replace(part, **{keys[0]: changed})


def _read(kind: Any, value: str, text: str) -> Any:
    from pydantic import TypeAdapter, ValidationError

    from colonysim.scenario.source import read_text

    read, _ = read_text(value, f"--set {text!r}", places=False)
    try:
        return TypeAdapter(kind).validate_python(read)
    except ValidationError as error:
        raise ColonysimError(f"--set {text!r}: {error.errors()[0]['msg']}") from None
