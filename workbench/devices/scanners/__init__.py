"""Scanners that are no cameras of GenICam: clouds as files, makers' libraries, several as one.

It may import `formats` and `model`, as all of `devices`.
"""
