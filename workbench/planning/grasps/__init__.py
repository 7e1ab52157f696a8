"""Grasps put on a part: checked, suggested, tried all over the bin.

Imports `kinematics`, `collision` and `picking`.
"""
