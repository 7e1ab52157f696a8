"""Commands about recorded sessions.

Imports `arguments` and `serving`.
"""
