"""Verdicts while a person drags a gizmo.

Imports `shared` and `scene`.
"""
