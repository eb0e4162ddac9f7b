"""Robot colonies that coordinate through marks left in the place itself, on any backend."""

__version__ = "0.1.0"
