"""First cell around a new robot: tools, bin, homes, places.

Imports no other folder of `studies`, of its files `targets`.
"""
