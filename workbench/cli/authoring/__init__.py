"""Commands that make and check cells, parts and grasps.

Imports `arguments`.
"""
