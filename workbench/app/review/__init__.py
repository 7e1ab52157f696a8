"""Recorded sessions looked at again: moment by moment, or computed anew and compared.

Imports all of app.
"""
