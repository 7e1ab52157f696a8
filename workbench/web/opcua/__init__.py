"""The state and a few commands for a PLC.

Imports `http`.
"""
