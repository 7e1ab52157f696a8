"""Scanners of cloud files; merged scanners.

It may import `formats` and `model`, as all of `devices`.
"""
