"""A session as one signed file, verified with Python alone.

May import everything of `app` and below.
"""
