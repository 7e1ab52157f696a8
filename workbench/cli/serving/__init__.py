"""Commands that run: the page, the controller, users, backups.

Imports `arguments` and `picking`.
"""
