"""Part localization: votes, fits, assessment, choice.

Imports `matching`, `parts`, `scene` and `views`.
"""
