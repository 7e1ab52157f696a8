"""The tab of a recorded session."""
