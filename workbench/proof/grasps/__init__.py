"""Proof of grasps, straight legs and unknown rolls.

Imports `model`, and of the proof bodies, kinematics and places.
"""
