"""Tab Emptying."""
