"""The tab that plays a plan."""
