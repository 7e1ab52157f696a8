"""The controller's end, simulated: it answers, moves in time, and fails when it is asked to.

Imports `abb_socket`.
"""
