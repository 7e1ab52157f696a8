"""Robots and worlds of Klamp't, read and written.

Imports `files`, `meshes` and `robots`.
"""
