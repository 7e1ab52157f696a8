"""How time, memory and bytes grow with the library, the bin, the session and the browsers.

Imports `load`.
"""
