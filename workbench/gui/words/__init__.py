"""Translation of what goes to one browser.

Imports words, gui.shared and viser.
"""
