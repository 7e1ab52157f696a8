"""What sessions have brought: how many parts, how surely, how fast, and with which grasps.

Imports `core`.
"""
