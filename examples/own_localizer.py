"""A localizer of one's own: two searches have to agree, and what comes out is planned for as ever.

Whatever finds parts ends in `Detection`s; planning and proof do not ask where they come from.
`docs/plugins/add_a_localizer.md` makes such a thing a plug-in that cell files can name.
"""

import numpy as np

import workbench as wb

APART = 0.002  # [m]
TURNED = 0.05  # [rad]


def agree(one: wb.Detection, other: wb.Detection) -> bool:
    """Whether two detections are of one part that lies alike, but for a turn about its axis z."""
    T = one.T_world_part.actInv(other.T_world_part)
    is_near = np.linalg.norm(T.translation) < APART
    return one.part == other.part and bool(is_near) and T.rotation[2, 2] > np.cos(TURNED)


cell = wb.read_cell("yumi")
pile = wb.drop_parts([cell.parts[0]] * 4, cell.bin, seed=3)
scan = wb.simulate_scan(cell, pile, seed=3)
coarse = wb.localize(cell, scan, seed=1, detail=0.7).detections
fine = wb.localize(cell, scan, seed=2, detail=1.3).detections
sure = [one for one in fine if any(agree(one, other) for other in coarse)]
print(f"{len(coarse)} parts found coarsely, {len(fine)} finely, {len(sure)} by both")
result = wb.plan(cell, sure, scan=scan)
if result.plan is None or result.proof is None:
    print(f"no plan: {result.verdict}")
else:
    print(f"{result.plan.strategy}, proven: {result.proof.holds}")
