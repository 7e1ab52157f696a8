"""Simulated piles, scans and scanner errors.

Imports `views`.
"""
