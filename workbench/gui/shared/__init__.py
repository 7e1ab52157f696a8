"""Base of all tabs: views, looks, colours, tables, controls.

Imports nothing of gui.
"""
