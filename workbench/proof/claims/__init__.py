"""What the proof asks of a plan: every rule that a plan is accepted or refused by.

Imports `model`, and `engine` for distances.  Read in this order:

- `prove`: the list of all claims
- `form`: cell, scene, joints
- `table`: which pairs keep which distance
- `stages`, `walk`: what moves in each stage of a leg, from the first step to the last
- `scene`: the bodies
- `motion`: every path that a controller may make of waypoints
- `grasps`, `places`, `tolerances`: how hands take parts, and where they put them
- `timing`: speeds, accelerations, jerk
- `spot`, `clearance`: the place that a violation names, and the least distances, for people
"""
