"""From parts found to a plan: candidates, the straight ways, the free ones, one arm or two.

Imports `kinematics`, `collision` and `planners`.
"""
