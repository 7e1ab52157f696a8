"""Path planners between configurations; they know no robot.

Imports collision: its compiled check of edges.
"""
