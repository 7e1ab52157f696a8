"""Messages: ids, typed arguments, English templates.

Code compares, stores and sends messages; their text is for people and is rendered last, in English
by `str`, in other languages by `workbench.words`.

Imports the standard library alone.
"""
