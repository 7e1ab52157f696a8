"""Computations that run in parallel with drawing, and who has watched what.

Imports `shared`, `scene`, `cell` and `emptying`.
"""
