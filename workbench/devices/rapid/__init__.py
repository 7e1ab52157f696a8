"""RAPID executed: tasks, robots, signals, operator and sockets, for modules as they are.

Imports the words of faults of `abb_simulated`.
"""
