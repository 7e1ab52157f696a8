"""Folders of parts: the mesh, what people say of it, and its grasps with every version of them.

Imports `files` and `meshes`.
"""
