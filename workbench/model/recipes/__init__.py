"""Recipes: what belongs together when a cell picks parts of a kind, by number and name."""
