"""A full bin, emptied: pile after pile, plan after plan, until nothing can be taken any more.

Imports nothing of other studies.
"""
