"""What is known of parts before they are looked for: surfaces, pair features, near-symmetries.

Imports `views`.
"""
