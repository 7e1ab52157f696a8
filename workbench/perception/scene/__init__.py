"""Bin fit, noise, and unknown things in a scan.

Imports `views`.
"""
