"""Motions checked as a whole by compiled code, for planners.

Imports bounds and the distance search of collision, kinematics.
"""
