"""The paper's tables and figures once more, beside the paper's own, with what agrees and what does not.

`plans` says which trials there are, `recorded` which runs are drawn, `paper` what the paper reports and claims,
`judging` when something agrees; the studies put them together, and `making` runs and writes all of it.
"""

from __future__ import annotations

from colonysim.reproduce.making import STUDIES, Made, reproduce

__all__ = ["STUDIES", "Made", "reproduce"]
