"""What tests of other packages can use: checks of what they bring, random scenarios, strategies."""

from typing import TYPE_CHECKING, Any

from colonysim.testing.backends import check_backend
from colonysim.testing.policies import check_policy
from colonysim.testing.promises import ConformanceError
from colonysim.testing.worlds import random_document, random_scenario

if TYPE_CHECKING:
    from colonysim.testing.environments import check_env
    from colonysim.testing.executors import check_executor

__all__ = [
    "ConformanceError", "check_backend", "check_env", "check_executor", "check_policy", "random_document",
    "random_scenario",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name == "check_env":  # it needs the extra `rl`
        from colonysim.testing.environments import check_env

        return check_env
    if name == "check_executor":  # it needs a rigid-body engine
        from colonysim.testing.executors import check_executor

        return check_executor
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
