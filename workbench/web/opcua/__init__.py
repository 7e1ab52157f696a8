"""OPC UA server for PLCs.

Imports `http`.
"""
