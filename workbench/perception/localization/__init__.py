"""Parts found in a scan: hypotheses by votes, fits, a last look, and a choice.

Imports `matching`, `parts`, `scene` and `views`.
"""
