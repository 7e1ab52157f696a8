"""Meshes as convex pieces, for collision checks: split by planes, joined where that serves."""
