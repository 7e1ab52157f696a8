"""Text of RAPID to words and syntax trees.

This folder imports `formats/rapid/problems.py` alone.
"""
