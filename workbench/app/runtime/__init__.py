"""Bench, jobs, threads, links and watchers.

Imports `core`, `picking` and `records`.
"""
