"""Our end of the socket link to ABB.

Imports nothing of the other devices.
"""
