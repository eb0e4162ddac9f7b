"""Being here puts `tests/` on the path, so that test modules can share code (`recorded_runs`)."""
