"""Kinds and turns told by colour, where shape leaves several open.

Imports `localization`, `parts` and `views`.
"""
