"""Tab Calibration."""
