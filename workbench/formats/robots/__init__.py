"""Robots from URDF, xacro and Denavit-Hartenberg tables, and robots written.

Imports `files` and `meshes`.
"""
