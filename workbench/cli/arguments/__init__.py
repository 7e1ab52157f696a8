"""Arguments as dataclasses, whose docstrings are the help.

Imports nothing of cli.
"""
