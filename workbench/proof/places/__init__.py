"""Proof of places, stations and pallets.

Imports `model`, and of the proof bodies and kinematics.
"""
