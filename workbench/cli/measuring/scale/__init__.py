"""Growth with the library, the bin, the session and the browsers.

Imports `arguments`, `page`, `serving`, `sessions`.
"""
