"""Seeded piles planned, and what came of each part: direct, over a station, or why not."""
