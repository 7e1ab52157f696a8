"""Plans and part poses as files.

Imports `files`.
"""
