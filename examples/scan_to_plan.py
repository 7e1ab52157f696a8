"""From a scan to a proven plan."""

import workbench as wb

cell = wb.read_cell("yumi")
pile = wb.drop_parts([cell.parts[0]] * 2, cell.bin, seed=3)
scan = wb.simulate_scan(cell, pile, seed=3)
found = wb.localize(cell, scan).detections
result = wb.plan(cell, found, scan=scan)
print(f"{len(pile)} parts in the bin, {len(found)} found")
if result.plan is None or result.proof is None:
    print(f"no plan: {result.verdict}")
else:
    seconds = result.plan.cycle_seconds
    print(f"{result.plan.strategy}: {seconds:.1f} s, proven: {result.proof.holds}")
    print(f"nowhere on free ways nearer than {result.proof.clearance * 1000:.1f} mm")
