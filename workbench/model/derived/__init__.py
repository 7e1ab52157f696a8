"""Cells made from a cell: by one of its recipes."""
