"""How fast colonies run, against bare SimPy timeouts as the yardstick; `colonysim bench`."""

from colonysim.bench.cases import CASES, Case
from colonysim.bench.measuring import Figures, measure
from colonysim.bench.report import compared, report, save, shares, stored

__all__ = ["CASES", "Case", "Figures", "compared", "measure", "report", "save", "shares", "stored"]
