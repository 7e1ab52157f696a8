"""Why grasps cannot be taken, and the smallest change that would help."""

from collections import Counter

import workbench as wb

cell = wb.read_cell("yumi")
pile = wb.drop_parts([cell.parts[0]] * 3, cell.bin, seed=11)
judged = wb.judge(cell, pile)
for reason, count in Counter(str(one.verdict.reason) for one in judged).most_common():
    print(f"{count:4} {reason}")
refused = [one for one in judged if not one.verdict.is_ok]
print("for example:", refused[0].grasp.name, "-", refused[0].verdict)
fix = wb.nearest_fix(cell, pile, judged, seed=0)
print("nearest fix:", "none of those tried" if fix is None else fix.change)
