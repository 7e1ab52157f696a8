"""Benchmarks and studies as commands.

Imports `arguments` and `serving`.
"""
