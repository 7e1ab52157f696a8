"""Parts found in a scan: hypotheses by votes, fits, a last look, and a choice.

`kinds.localize_parts` finds all parts of all kinds in one scan.

Imports `matching`, `parts`, `scene` and `views`.
"""
