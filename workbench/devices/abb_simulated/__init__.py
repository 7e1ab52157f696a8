"""The simulated ABB controller.

Imports `abb_socket`.
"""
