"""Colours that decide between kinds and turns.

Imports `localization`, `parts` and `views`.
"""
