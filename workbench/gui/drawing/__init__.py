"""Background computations for drawing; watching of plans.

Imports `shared`, `scene`, `cell` and `emptying`.
"""
