"""The shared scene, and each browser's additions.

Imports `shared`.
"""
