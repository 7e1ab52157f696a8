"""A closed surface from several scans of one part, whose poses are known.

Imports `views`.
"""
