"""Plans and poses of parts in files, for other programs.

Imports `files`.
"""
