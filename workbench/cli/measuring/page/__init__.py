"""Benchmarks of the page, which a process of its own serves.

Imports `arguments`.
"""
