"""Folders of cells: read, changed in place, written anew; calibrations and predictions beside them.

Imports `files`, `meshes`, `robots` and `parts`.
"""
