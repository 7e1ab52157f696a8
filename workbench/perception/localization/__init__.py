"""Part localization: votes, fits, assessment, choice.

`kinds.localize_parts` finds all parts of all kinds in one scan.

Imports `matching`, `parts`, `scene` and `views`.
"""
