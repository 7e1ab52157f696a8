"""What the proof asks of a plan: every rule that a plan is accepted or refused by.

Imports `model`, and `engine` for distances.  Read in this order:

- `prove`: the list of all claims
- `form`: cell, scene, joints
- `timing`: speeds, accelerations, jerk
- `grasps`, `places`, `tolerances`: how hands take parts, and where they put them
- `scene`: the bodies
- `stages`, `motion`: every way in which a plan may be executed
- `table`: which pairs keep which distance
- `walk`: the plan from its first step to its last
- `spot`: the place that a violation names, for people
"""
