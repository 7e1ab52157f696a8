"""Commands about the scanner: where it is, how it scans, whether it has moved."""
