"""The HTTP interface for programs, its description made from the same tables as its routes.

Imports nothing of web.
"""
