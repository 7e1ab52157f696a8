"""The study of grips: whether what is said to hold a part's weight does.

Imports nothing of other studies but how cases are run.
"""
