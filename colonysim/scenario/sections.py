"""What the sections of a scenario file are made of: numbers with their limits, and mappings without unknown fields."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, Strict

__all__ = [
    "LARGEST", "SMALLEST", "Coordinate", "Count", "Flag", "Length", "Metres", "NodeId", "NotNegative", "Pair",
    "Positive", "Scale", "Seconds", "Section", "Seed", "Size", "Text",
]  # fmt: skip

LARGEST, SMALLEST = 1e9, 1e-6
"""No number is larger, and no length, height or time that cannot be 0 is smaller: sums of all of them stay exact
enough, and products finite."""

NodeId = Annotated[int, Strict(), Field(ge=0, le=10**15)]
Count = Annotated[int, Strict(), Field(ge=1, le=10**9)]
Seed = Annotated[int, Strict(), Field(ge=0, le=10**18)]
Coordinate = Annotated[float, Strict(), Field(ge=-LARGEST, le=LARGEST, allow_inf_nan=False)]
NotNegative = Annotated[float, Strict(), Field(ge=0, le=LARGEST, allow_inf_nan=False)]
Length = Annotated[float, Strict(), Field(ge=SMALLEST, le=LARGEST, allow_inf_nan=False)]
Seconds = Annotated[float, Strict(), Field(ge=SMALLEST, le=LARGEST, allow_inf_nan=False)]
Scale = Annotated[float, Strict(), Field(ge=1e-4, le=1e4, allow_inf_nan=False)]
Metres = Annotated[float, Strict(), Field(ge=-1e4, le=1e4, allow_inf_nan=False)]
Size = Annotated[float, Strict(), Field(ge=0.01, le=1e3, allow_inf_nan=False)]
"""Of a body or a part of the ground, metres."""
Positive = Annotated[float, Strict(), Field(gt=0, le=1e6, allow_inf_nan=False)]
"""Of a robot; which numbers its controls can handle is for the physics to say."""
Text = Annotated[str, Strict()]
Flag = Annotated[bool, Strict()]
Pair = tuple[NodeId, NodeId]


class Section(BaseModel):
    """A mapping in the file; unknown fields are mistakes."""

    model_config = ConfigDict(extra="forbid", frozen=True)
