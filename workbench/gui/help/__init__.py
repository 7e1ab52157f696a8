"""Help texts of the groups, with links to the manual.

Imports nothing of the page.
"""
