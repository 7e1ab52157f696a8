"""The language alone: modules read, checked and made callables, with its data and functions.

Imports nothing of what runs them.
"""
