"""What becomes of each part of a pile: directly, over a station, or from hand to hand.

`picks` plans seeded piles and counts; `exchanges` searches for handovers in the air.
"""
