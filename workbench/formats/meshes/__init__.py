"""Meshes: read, repaired, cut into convex pieces; solids.

Imports `files`, and of `clouds` what PCD files hold.
"""
