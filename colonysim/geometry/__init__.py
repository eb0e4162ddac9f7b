"""From a scenario's graph to metres: how large things are, and where ground, pits, ramps, boxes and robots lie."""
