"""Units of length that files may have."""

UNITS = {"mm": 0.001, "m": 1.0, "inch": 0.0254}
"""Name -> metres."""
