"""A session as one signed file; a cell's acceptance record.

Signing needs `cryptography` and reports in PDF need `matplotlib`, of the extra `evidence`.
"""
