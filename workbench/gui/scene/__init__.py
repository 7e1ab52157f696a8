"""What is drawn: the picture that all share, and what one browser sees over it.

Imports `shared`.
"""
