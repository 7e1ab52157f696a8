"""Modbus TCP server for small PLCs."""
