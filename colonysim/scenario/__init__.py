"""What a colony is told beforehand: the scenario file, read, checked, filled in, or invented."""
