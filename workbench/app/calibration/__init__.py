"""Where the scanner hangs: its first scan, poses of a held plate, what it has drifted since.

Imports `core`.
"""
