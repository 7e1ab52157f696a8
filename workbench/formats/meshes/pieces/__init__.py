"""Meshes as convex pieces, for collision checks: cut by CoACD or split along planes."""
