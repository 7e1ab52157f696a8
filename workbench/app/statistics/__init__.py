"""Counts and rates over sessions.

Imports `core`.
"""
