"""Where links are for joint values, and joint values for a pose of the tool.

Imports nothing of planning.
"""
