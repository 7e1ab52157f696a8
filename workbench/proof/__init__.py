"""The proof of a plan, by code that imports nothing of planning.

Imports `model` alone.  Kinematics (Pinocchio), distances (Coal), the table of pairs and the bounds
are its own, so that an error of the planner is none here.  Both share `model`: an error in what it
derives escapes the proof: a bin's room, grasps that a library allows, turns of a symmetry, resting
and assembled poses, insertions, limits of speed, convex pieces.

`claims` says what is promised and asked: begin there, with `claims.prove`.  `engine` answers how
near bodies come along motions; it knows no plan, no rule and no margin.
"""
