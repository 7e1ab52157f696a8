"""Part folders: mesh, statements, versions of grasps.

Imports `files` and `meshes`.
"""
