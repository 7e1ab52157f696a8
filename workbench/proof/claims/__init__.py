"""What the proof asks of a plan: every rule that a plan is accepted or refused by.

Imports `model`, and `engine` for distances.  Read in this order: `prove` (the list of all claims),
`form` (cell, scene, joints), `timing` (speeds, accelerations, jerk), `grasps` (how hands take
parts), `places`, `tolerances`, `scene` (the bodies), `stages` and `motion` (every way in which a
plan may be executed), `table` (which pairs keep which distance), `walk` (the plan from its first
step to its last).  `spot` finds the place that a violation names, for people.
"""
