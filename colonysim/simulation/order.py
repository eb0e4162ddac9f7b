"""The order of what happens at one time: SimPy's priorities, the lowest first.

SimPy's own events have 0 and 1. Within each kind the order is drawn: a priority is one of these numbers and a lot
below 1. Changes have no lots: they happen in the order of the file.
"""

__all__ = ["CHANGES", "CHANGE_STEP", "CLOCK", "ENDS", "LAST", "MOVED", "WOKEN"]

CLOCK = 1.0
"""The clock of a backend with ticks."""
CHANGES, CHANGE_STEP = 1.5, 1e-6
"""Changes of the timeline; by so much they differ from one to the next."""
ENDS = 2.0
"""Actions end."""
WOKEN = 3.0
"""Who was woken by it goes on."""
MOVED = 4.0
"""Who has just made others choose goes on."""
LAST = 8.0
"""None is higher."""
