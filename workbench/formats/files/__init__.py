"""Base of all readers: whole files, strict keys, archives, units.

Imports nothing of the other formats.
"""
