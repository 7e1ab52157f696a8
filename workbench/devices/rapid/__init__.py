"""RAPID interpreter: tasks, robots, signals, sockets.

Imports the words of faults of `abb_simulated`.
"""
