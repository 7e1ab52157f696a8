"""From detections to a plan: candidates, legs, one or two arms.

Imports `kinematics`, `collision` and `planners`.
"""
