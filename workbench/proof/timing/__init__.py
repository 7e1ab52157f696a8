"""Speeds, accelerations and jerk along whole legs: whether a motion can be as a plan says.

Imports `model` alone.
"""
