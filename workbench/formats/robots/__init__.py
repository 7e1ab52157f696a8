"""Robots from URDF, xacro and Denavit-Hartenberg tables.

Imports `files` and `meshes`.
"""
