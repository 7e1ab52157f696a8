"""Browsers without a screen, many of them: they read all, one of them scrubs and types.

Imports nothing of studies.
"""
