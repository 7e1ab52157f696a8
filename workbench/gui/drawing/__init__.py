"""What is worked out beside the drawing, and who has seen it.

Imports `shared`, `scene`, `cell` and `emptying`.
"""
