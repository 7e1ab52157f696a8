"""What every tab stands on: views, looks, colours, tables, one browser's controls.

Imports nothing of gui.
"""
