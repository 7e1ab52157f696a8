"""Parts found in a scan: hypotheses by votes, fits, a last look, and a choice.

Imports `parts`, `scene` and `views`.
"""
