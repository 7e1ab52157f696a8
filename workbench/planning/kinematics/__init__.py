"""Forward and inverse kinematics, timing.

Imports nothing of planning.
"""
