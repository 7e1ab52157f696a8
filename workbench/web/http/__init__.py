"""Rules of every connection and answer: limits, origins, headers.

Imports nothing of web.
"""
