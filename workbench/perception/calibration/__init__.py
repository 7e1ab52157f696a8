"""Where the scanner hangs: a plate of balls, found and fitted; and whether it still hangs there.

Imports `simulation`, for the picture of a plate that is held, and `scene`, for the bin.
"""
