"""A first cell around a robot that nobody has used here: its arms, tools, bin, homes and places.

Imports no other folder of `studies`, of its files `targets`.
"""
