"""RAPID modules: parsed, checked, made callable.

`syntax/` reads text, `robotware/` knows what every controller has, `backups/` finds out which files
belong together.
"""
