"""Texts of the page that hold values, by subject."""
