"""Speeds and accelerations along whole legs: whether a motion can be as a plan says.

Imports `model` alone.
"""
