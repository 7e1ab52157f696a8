"""The second look at a finished plan, on exactly what will be sent.

Imports `kinematics` and `collision`.
"""
