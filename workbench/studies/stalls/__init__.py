"""What holds up the page's process: how long, and by which line.

Imports nothing of studies but the browsers without a screen.
"""
