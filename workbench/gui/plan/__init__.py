"""Tab Plan."""
