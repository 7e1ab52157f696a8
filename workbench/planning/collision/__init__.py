"""Collision world, pairs, distances, swept motions.

Imports `kinematics`.
"""
