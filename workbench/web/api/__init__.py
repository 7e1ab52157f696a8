"""HTTP interface and its OpenAPI description.

Imports nothing of web.
"""
