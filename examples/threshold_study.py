"""From which distance on both arms should work at once: what it does to the time of a cycle.

Parts that lie near each other are taken by one arm after the other, parts far apart by both arms
at once.  Every pile is planned both ways; from that follows what any distance would have brought.
Only piles count for which both plans are proven.
`workbench study threshold` does the same with hundreds of piles.
"""

import numpy as np

import workbench as wb

cell = wb.read_cell("yumi")
piles = [(wb.drop_parts([cell.parts[0]] * 2, cell.bin, seed=seed), seed) for seed in range(14)]


def seconds(pile: tuple[wb.Detection, ...], strategy: str, seed: int) -> float | None:
    """How long the cycle takes [s]; None when there is no such plan, or no proof of it."""
    result = wb.plan(cell, pile, strategy=strategy, seed=seed)
    is_proven = result.proof is not None and result.proof.holds
    return result.plan.cycle_seconds if result.plan is not None and is_proven else None


rows: list[tuple[float, float, float]] = []
for pile, seed in piles:
    one_by_one, at_once = (seconds(pile, name, seed) for name in ("alternated", "coordinated"))
    if one_by_one is not None and at_once is not None:
        first, second = (part.T_world_part.translation for part in pile)
        rows.append((float(np.linalg.norm(first - second)), one_by_one, at_once))
print(f"{len(rows)} of {len(piles)} piles are proven both ways")
print("at once from   piles at once   mean cycle")
for threshold in (0.0, 0.1, 0.15, 0.2, 0.3):
    at_once = [row[2] for row in rows if row[0] >= threshold]
    others = [row[1] for row in rows if row[0] < threshold]
    mean = np.mean(at_once + others)
    print(f"{threshold * 1000:9.0f} mm {len(at_once):15} {mean:10.1f} s")
print(f"the cell's own distance: {cell.policy.threshold * 1000:.0f} mm")
