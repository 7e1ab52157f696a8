"""Scanners that speak GenICam over GigE Vision, by the library aravis."""
