"""What runs: the bench, its jobs and threads, links and watchers.

Imports `core`, `picking` and `records`.
"""
