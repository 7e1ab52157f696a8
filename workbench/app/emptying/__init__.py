"""Simulated emptying of a full bin.

May import `app.core` and `app.picking`; knows no worker and no files.
"""
