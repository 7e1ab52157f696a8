"""From parts found to a plan: candidates, straight legs, free paths, for one arm or two.

`app.picking.pipeline` calls `propose`, `resolve` and `plan_first_feasible` in this order.

Imports `kinematics`, `collision` and `planners`.
"""
