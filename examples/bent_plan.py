"""A plan that somebody has changed is not proven, and nobody can approve it."""

import math
from dataclasses import replace

import workbench as wb

cell = wb.read_cell("yumi")
pile = wb.drop_parts([cell.parts[0]] * 2, cell.bin, seed=3)
plan = wb.plan(cell, pile).plan
assert plan is not None
arm = plan.arms[0]
legs = []
for leg in arm.legs:
    q = leg.q.copy()
    if leg.name == "reach":
        q[1:-1, 1] += math.radians(40)
    legs.append(replace(leg, q=q))
bent = replace(plan, arms=(replace(arm, legs=tuple(legs)), *plan.arms[1:]))
proof = wb.prove(cell, bent)
print(f"{len(proof.violations)} objections, the first: {proof.violations[0]}")
try:
    wb.approve(cell, bent, proof, "Ada")
except wb.CommandRefused as error:
    print("refused:", error)
