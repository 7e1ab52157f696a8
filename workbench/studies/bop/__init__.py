"""Localization measured as BOP does it: its errors of poses, its average precision."""
