"""A full bin, emptied in simulation: plan after plan, until nothing can be taken any more.

May import `app.core` and `app.picking`; knows no worker and no files.
"""
