"""The tab with the parts found."""
