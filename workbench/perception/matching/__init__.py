"""A scan as maps, and what poses of a part predict held against them.

Imports `parts`, `scene` and `views`.
"""
