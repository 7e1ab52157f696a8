"""GenICam scanners over GigE Vision, by aravis."""
