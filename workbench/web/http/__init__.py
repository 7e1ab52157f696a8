"""What holds for every connection and every answer: how many, from where, with which headers.

Imports nothing of web.
"""
