"""What browsers send, checked against what their page offers them.

May import model; nothing else of gui.
"""
