"""Inventory of software, machine, cell and people at each start.

May import model and formats.
"""
