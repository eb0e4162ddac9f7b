"""What tests of other packages can use: checks of policies and backends, random scenarios, strategies."""

from colonysim.testing.backends import check_backend
from colonysim.testing.policies import check_policy
from colonysim.testing.promises import ConformanceError
from colonysim.testing.worlds import random_document, random_scenario

__all__ = ["ConformanceError", "check_backend", "check_policy", "random_document", "random_scenario"]
