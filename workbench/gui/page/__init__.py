"""Page server, renderer thread, header and tabs.

Imports all of gui.
"""
