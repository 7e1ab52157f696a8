"""Noise, the robot, and unknown things in a scan.

Imports `bins` and `views`.
"""
