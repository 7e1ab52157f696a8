"""Scenes that nobody had to build: piles, scans of them, and what is wrong with scans.

Imports `views`.
"""
