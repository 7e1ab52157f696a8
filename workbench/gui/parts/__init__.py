"""Tab Parts."""
