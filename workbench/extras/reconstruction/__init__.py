"""Closed surfaces from scans with known poses."""
