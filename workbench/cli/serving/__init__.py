"""Commands that keep running: page, controller; users, backups.

Imports `arguments` and `picking`.
"""
