"""Values in, values out: reach, collision, paths, and the proof of them."""
