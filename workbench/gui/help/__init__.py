"""What the groups of controls are for, in three sentences each, with a way into the manual.

Imports nothing of the page.
"""
