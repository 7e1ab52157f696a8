"""Tab Robot."""
