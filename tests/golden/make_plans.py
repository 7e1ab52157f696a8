"""The plans of forty seeded scenes, to see whether a change of the code changes any of them.

`python tests/golden/make_plans.py` makes `plans.jsonl` anew: only when plans are meant to change.
A scene is kept with its poses, so that planning alone is compared, and no physics.
"""

import json
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from shipped import without_search

from workbench.app.picking.pipeline import plan_pick
from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.cell import Cell
from workbench.model.plan import Plan
from workbench.model.scan import Detection
from workbench.perception.simulation.piles import drop_parts

FILE = Path(__file__).with_name("plans.jsonl")

SECONDS = 600.0
"""[s] For each plan: none of these may depend on how quick the machine is."""

SCENES = {
    "two parts": ("yumi", ("keyed_cylinder",) * 2, 12),
    "eight parts": ("yumi", ("keyed_cylinder",) * 8, 8),
    "one arm": ("tx2_90", ("puck",) * 4, 10),
    "three kinds": ("yumi", ("keyed_cylinder", "bolt", "bracket") * 2, 10),
}
"""Cell, parts, and how many piles of them."""


def cell_of(name: str) -> Cell:
    """The cell of these scenes, with their parts and time enough."""
    cell_name, kinds, _ = SCENES[name]
    cell = read_cell(cell_name)
    parts = tuple(read_part(kind) for kind in dict.fromkeys(kinds))
    cell = replace(cell, parts=parts, policy=replace(cell.policy, seconds=SECONDS))
    return without_search(cell)


def planned(cell: Cell, detections: tuple[Detection, ...], seed: int) -> dict[str, Any]:
    """What planning makes of a scene, without what names and digests enter."""
    result = plan_pick(cell, detections, "golden", seed=seed)
    verdicts = Counter(str(one.verdict.reason) for one in result.candidates)
    return {
        "verdicts": dict(sorted(verdicts.items())),
        "proven": result.proof is not None and result.proof.holds,
        "plan": None if result.plan is None else contents(result.plan),
    }


def contents(plan: Plan) -> dict[str, Any]:
    """What moves: for each arm its part, its grasp, and its waypoints [0.01 degrees]."""
    return {
        "strategy": str(plan.strategy),
        "sequence": [list(map(list, step.runs)) for step in plan.sequence],
        "cycle [ms]": round(1000 * plan.cycle_seconds),
        "arms": {
            arm.arm: {
                "detection": arm.detection,
                "grasp": arm.grasp,
                **{
                    leg.name: np.rint(np.rad2deg(leg.q) * 100).astype(int).tolist()
                    for leg in arm.legs
                },
            }
            for arm in plan.arms
        },
    }


def kept() -> Iterator[tuple[str, int, tuple[Detection, ...], dict[str, Any]]]:
    """The scenes of the file: name, seed, detections, and what planning made of them."""
    for line in FILE.read_text().splitlines():
        one = json.loads(line)
        yield one["scene"], one["seed"], tuple(map(_detection, one["parts"])), one["planned"]


def _detection(row: list[Any]) -> Detection:
    kind, *numbers = row
    pose = np.reshape(numbers, (3, 4))
    return Detection(kind, pin.SE3(pose[:, :3], pose[:, 3]))


def _row(detection: Detection) -> list[Any]:
    return [detection.part, *detection.T_world_part.homogeneous[:3].ravel().tolist()]


def main() -> None:
    """Write the file; the piles stay as they are."""
    before = {(name, seed): (pile, plan) for name, seed, pile, plan in kept()}
    lines = []
    for name, (_, kinds, count) in SCENES.items():
        cell = cell_of(name)
        known = {part.name: part for part in cell.parts}
        for seed in range(100, 100 + count):
            pile, plan = before.get((name, seed), ((), None))
            pile = pile or drop_parts([known[kind] for kind in kinds], cell.bin, seed=seed)
            now = planned(cell, pile, seed)
            scene = {"scene": name, "seed": seed, "parts": list(map(_row, pile))}
            lines.append(json.dumps(scene | {"planned": now}))
            print(name, seed, "as before" if now == plan else "ANOTHER PLAN", flush=True)
    FILE.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
