"""The work behind the commands: a plan, a calibration, a part from a CAD file, facts.

Imports `core`.
"""
