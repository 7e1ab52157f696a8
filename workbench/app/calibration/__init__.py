"""Scanner calibration: first scan, plate poses, drift.

Imports `core`.
"""
