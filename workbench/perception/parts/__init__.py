"""Part preparation: surfaces, pair features, near-symmetries.

Imports `views`.
"""
