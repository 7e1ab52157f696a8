"""Modbus TCP server for small PLCs.

Imports `http`.
"""
