"""Depth maps of a scan, compared with drawn parts.

Imports `parts`, `scene` and `views`.
"""
