"""Recorded sessions: shown, computed again and compared.

Imports all of app.
"""
