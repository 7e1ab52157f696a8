"""Proof of speeds, accelerations and jerk along legs.

Imports `model` alone.
"""
