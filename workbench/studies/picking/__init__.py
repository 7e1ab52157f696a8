"""Outcome of each part of a pile: direct, station, handover.

`picks` plans seeded piles and counts; `exchanges` searches for handovers in the air.
"""
