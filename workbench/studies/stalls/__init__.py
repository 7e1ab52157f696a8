"""What blocks the page's process, by line of code.

Imports nothing of studies but the browsers without a screen.
"""
