"""Grasps suggested for a part, tried in a bin instead of those that its folder has."""

from dataclasses import replace

import workbench as wb

cell = wb.read_cell("yumi")
part = wb.read_part("bracket")
ideas = wb.suggest(part, cell.arms[0].tool, seed=0)
print(f"{len(ideas)} grasps suggested:", ", ".join(one.grasp.name for one in ideas[:4]), "...")
part = replace(part, library=wb.GraspLibrary(tuple(one.grasp for one in ideas)))
cell = replace(cell, parts=(part,))
pile = wb.drop_parts([part] * 2, cell.bin, seed=5)
result = wb.plan(cell, pile)
taken = () if result.plan is None else result.plan.arms
print("taken by:", ", ".join(f"{one.arm} arm, {one.grasp}" for one in taken) or result.verdict)
