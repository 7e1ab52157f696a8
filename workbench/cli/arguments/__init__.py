"""What can be typed: dataclasses whose docstrings are the help; nothing heavy is loaded.

Imports nothing of cli.
"""
