"""Evidence: a session as one signed file that others verify with Python alone.

May import everything of `app` and below.
"""
