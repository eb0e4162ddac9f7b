"""What a run leaves behind, and the way back to it."""
