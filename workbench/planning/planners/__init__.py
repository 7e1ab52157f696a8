"""Ways between two configurations, by whatever planner; they know no robot.

Imports collision: its compiled check of edges.
"""
