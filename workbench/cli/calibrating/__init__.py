"""Commands about the scanner: calibration, first scan, drift."""
