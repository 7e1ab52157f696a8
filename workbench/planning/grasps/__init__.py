"""Grasps on a part: checked, suggested, tried over the bin.

Imports `kinematics`, `collision` and `picking`.
"""
