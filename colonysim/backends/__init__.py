"""Backends: what turns decisions into motion, found by name or entry point (`colonysim.backends`)."""
