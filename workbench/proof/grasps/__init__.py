"""How hands take parts: grasps as authored, straight lines, and parts of unknown roll.

Imports `model`, and of the proof bodies, kinematics and places.
"""
