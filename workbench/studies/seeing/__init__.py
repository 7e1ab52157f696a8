"""Absent parts, and wrong CAD files."""
