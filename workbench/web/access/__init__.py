"""Who comes in: users, passwords, logins and tokens, and what is done against guessing.

Imports `http`.
"""
