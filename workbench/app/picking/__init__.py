"""The work behind the commands: a plan and its proof, rows, stations, a part from a CAD file.

Imports `calibration` and `core`.
"""
