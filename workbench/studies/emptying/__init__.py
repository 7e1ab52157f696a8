"""Study of emptying: stored piles, plots.

Imports nothing of other studies.  How a pile is emptied stands in `app.emptying`.
"""
