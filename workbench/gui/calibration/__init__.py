"""The tab that finds out where the scanner hangs."""
