"""CAD files that people upload."""
