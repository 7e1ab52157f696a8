"""Study of grips under weight.

Imports nothing of other studies but how cases are run.
"""
