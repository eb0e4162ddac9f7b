"""Policies: what decides, from a local view. Found by name, entry point (`colonysim.policies`) or "module:Name"."""

from colonysim.policies.outside import Outside
from colonysim.policies.parameters import read_parameters
from colonysim.policies.policy import Choice, Policy
from colonysim.policies.view import LocalView, OutOfSightError

__all__ = ["Choice", "LocalView", "OutOfSightError", "Outside", "Policy", "read_parameters"]
