"""Searches for grasps behind a button, which a button stops."""
