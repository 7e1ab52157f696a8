"""Browser messages, checked against the offered controls.

May import model; nothing else of gui.
"""
