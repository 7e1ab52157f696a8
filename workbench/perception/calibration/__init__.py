"""Where the scanner hangs: a plate of balls, found and fitted.

Imports `simulation`, for the picture of a plate that is held.
"""
