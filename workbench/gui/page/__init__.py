"""The page as a whole: its server, the thread that draws, header and tabs.

Imports all of gui.
"""
