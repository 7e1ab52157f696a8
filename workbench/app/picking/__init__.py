"""Planning and proof behind the commands, rows, stations, part import.

Imports `calibration` and `core`.
"""
