"""Parts found in a scan: hypotheses by votes, fits, a last look, and a choice.

Imports `scene` and `views`.
"""
