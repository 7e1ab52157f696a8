"""Sessions as they are kept: entries as bytes, replayed, counted, packed.

Imports `core`, `picking` and `statistics`.
"""
