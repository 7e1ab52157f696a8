"""Data sets in the layout of BOP, the benchmark for poses of objects, and its files of results.

The layout: bop_toolkit, docs/bop_datasets_format.md (Hodan et al.).
"""
