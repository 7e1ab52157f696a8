"""Proof of grasps, straight legs and unknown rolls.

Imports `model`, `engine`, and of the claims the scene, stages and places.
"""
