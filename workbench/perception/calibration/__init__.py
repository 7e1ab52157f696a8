"""Scanner calibration by a plate of balls; drift.

Imports `simulation`, for the picture of a plate that is held, and `scene`, for the bin.
"""
