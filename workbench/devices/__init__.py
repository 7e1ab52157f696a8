"""All talk with machines: scanners and robot controllers."""
