"""What one browser is told, in its language, on the way out.

Imports words, gui.shared and viser.
"""
