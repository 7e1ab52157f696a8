"""What every reader and writer stands on: whole files, strict keys, archives, units.

Imports nothing of the other formats.
"""
