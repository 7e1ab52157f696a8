"""Proof of places, stations, pallets and assemblies.

Imports `model`, `engine`, and of the claims the scene and stages.
"""
