"""Proof of places, stations and pallets.

Imports `model`, `engine`, and of the claims the scene and stages.
"""
