"""Ways between two configurations, by whatever planner; they know no robot.

Imports nothing of planning.
"""
