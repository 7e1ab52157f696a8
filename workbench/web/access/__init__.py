"""Users, passwords, logins, tokens, lockout.

Imports `http`.
"""
