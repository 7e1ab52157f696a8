"""Seams: what other packages add without a change here, and how it is found.

One file a seam: a protocol whose docstring is its specification.  Imports `model` alone; what is
found is loaded by its name.
"""
