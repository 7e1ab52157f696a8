"""Robots and worlds of Klamp't.

Imports `files`, `meshes` and `robots`.
"""
