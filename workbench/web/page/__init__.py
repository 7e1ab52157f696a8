"""Page around the scene; relay between browser and viser.

Imports `http` and `access`.
"""
