"""Cell folders: read, edited, written; calibrations.

Imports `files`, `meshes`, `robots` and `parts`.
"""
