"""Grippers from URDF and xacro: what moves of them, and the tool that follows.

Imports `files`, `meshes` and `robots`.
"""
