"""What tests of other packages can use: checks of policies, backends and environments, random scenarios, strategies."""

from typing import TYPE_CHECKING, Any

from colonysim.testing.backends import check_backend
from colonysim.testing.policies import check_policy
from colonysim.testing.promises import ConformanceError
from colonysim.testing.worlds import random_document, random_scenario

if TYPE_CHECKING:
    from colonysim.testing.environments import check_env

__all__ = ["ConformanceError", "check_backend", "check_env", "check_policy", "random_document", "random_scenario"]


def __getattr__(name: str) -> Any:
    if name == "check_env":  # it needs the extra `rl`
        from colonysim.testing.environments import check_env

        return check_env
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
