"""How near bodies come in a whole set of configurations, bounded from below.

Imports `model` and nothing of `claims`.  Read in this order: `robot` (joints), `bodies` and
`shapes` (what is measured), `pairs` and `sets` (which distances, in which configurations),
`search` (halves sets until every pair is decided), `space` (measures a configuration).  Compiled
below: `batch`, `frames`, `sieve` and `plane`.
"""
