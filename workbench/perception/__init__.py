"""Clouds in, poses out: pure functions."""
