"""Data sets and results in BOP's layout.

The layout: bop_toolkit, docs/bop_datasets_format.md (Hodan et al.).
"""
