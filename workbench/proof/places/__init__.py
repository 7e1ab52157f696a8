"""Where parts are put down: whether they lie as a place asks, or stand on a station.

Imports `model`, and of the proof bodies and kinematics.
"""
