"""Tab Statistics."""
