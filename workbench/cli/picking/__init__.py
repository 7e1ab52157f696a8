"""Commands from a scan to a proven plan.

Imports `arguments`.
"""
