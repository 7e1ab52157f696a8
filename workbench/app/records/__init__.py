"""Session records: encoded, replayed, counted, packed.

Imports `core`, `picking` and `statistics`.
"""
