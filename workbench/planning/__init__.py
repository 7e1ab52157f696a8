"""Values in, values out: reach, collision, and paths."""
