"""The study of emptying: piles by their cell's name, kept in a folder, drawn.

Imports nothing of other studies.  How a pile is emptied stands in `app.emptying`.
"""
