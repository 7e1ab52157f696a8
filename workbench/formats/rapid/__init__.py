"""RAPID, the language of ABB's controllers: modules read, checked and made callables.

`syntax/` reads text, `robotware/` knows what every controller has, `backups/` finds out which files
belong together.
"""
