"""Commands that measure searches for absent parts, and by wrong CAD files."""
