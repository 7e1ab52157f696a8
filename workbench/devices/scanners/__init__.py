"""Other scanners: cloud files, makers' libraries, merged.

It may import `formats` and `model`, as all of `devices`.
"""
