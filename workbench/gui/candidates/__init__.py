"""Tab Candidates."""
