"""Load test by many browsers without a screen.

Imports nothing of studies.
"""
