"""The proof of a plan, by code that shares nothing with planning.

Imports `model` alone: its own kinematics (Pinocchio) and distances (Coal), its own table of which
pairs count, and its own bounds.  So an error of the planner is not an error here.

To read it, begin with `prove`, then what is asked: `form` (cell, scene, joints), `timing` (speeds
and accelerations), `grasps` (how hands take parts), `places`, `tolerances` (in metres of any
point), `stages` and `motion` (what moves, and every way it may be done), `table` (which pairs keep
what distance), `walk`.  How it is answered: `search` halves
sets of configurations, over `space` (where bodies are, measured) and what is compiled, `batch`,
`frames`, `sieve` and `plane`.
`spot` is for people: where a place is that a proof names.
"""
