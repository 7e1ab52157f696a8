"""The page around the scene, and what passes between a browser and viser.

Imports `http` and `access`.
"""
