"""Triangle meshes: read, mended, cut into convex pieces; and solids as files describe them.

Imports `files`, and of `clouds` what PCD files hold.
"""
