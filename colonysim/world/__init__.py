"""What is: topology, state and the rules of the place. No SimPy, no physics, no randomness, no files."""
