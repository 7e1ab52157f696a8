"""A plan that somebody has changed is not proven, and nobody can approve it."""

from dataclasses import replace

import workbench as wb

cell = wb.read_cell("yumi")
pile = wb.drop_parts([cell.parts[0]] * 2, cell.bin, seed=3)
plan = wb.plan(cell, pile).plan
assert plan is not None
arm = plan.arms[0]
legs = tuple(replace(leg, q=leg.q + 0.2) if leg.name == "approach" else leg for leg in arm.legs)
bent = replace(plan, arms=(replace(arm, legs=legs), *plan.arms[1:]))
proof = wb.prove(cell, bent)
print(f"{len(proof.findings)} objections, the first: {proof.findings[0]}")
try:
    wb.approve(cell, bent, proof, "Ada")
except wb.CommandRefused as error:
    print("refused:", error)
