"""How near bodies come in a whole set of configurations, bounded from below.

Imports `model` and nothing of `claims`.  Read `robot` (joints) first, then `bodies` and `shapes`
(what is measured), `pairs` and `sets` (which distances, in which configurations).  Then read
`search` (halves sets until every pair is decided) and `space` (measures a configuration).  The
compiled modules are `batch`, `frames`, `sieve` and `plane`.
"""
