"""Tab of a recorded session."""
