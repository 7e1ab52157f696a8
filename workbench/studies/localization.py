"""How well and how fast parts are found: seeded piles, simulated scans, true poses to compare."""

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from workbench.formats.cells import read_cell
from workbench.model.part import Part
from workbench.model.scan import Detection
from workbench.perception.localize import localize
from workbench.perception.piles import drop_parts
from workbench.perception.synthesize import synthesize

NEAR = 0.02
"""[m] A detection belongs to the true part whose origin is nearest, up to here."""

WRONG = np.deg2rad(5.0)
"""[rad] A detection that is turned by more is not merely imprecise, it is wrong."""


def measure(
    cell_name: str,
    *,
    scenes: int,
    parts: int = 2,
    seed: int = 0,
    report: Callable[[float, str], None] = lambda done, note: None,
) -> dict[str, Any]:
    """Scan and localize every pile once.

    One scene is localized before the clock starts, so that compiled code is loaded.

    Args:
        cell_name: name or path of a cell.
        scenes: how many piles.
        parts: how many parts in each.
        seed: of the first pile; the others follow.
        report: progress.

    Returns:
        `counts` by name, and lists: `distance` [m], `tilt` and `roll` [rad] of what was found
        right (roll only where it is said to be known), `seconds` a scene.
    """
    cell = read_cell(cell_name)
    part = cell.parts[0]
    counts = dict.fromkeys(("parts", "missed", "ghosts", "wrong", "roll unknown"), 0)
    errors: dict[str, list[float]] = {"distance": [], "tilt": [], "roll": [], "seconds": []}
    for number in range(scenes):
        report(number / scenes, f"pile {seed + number}")
        one = seed + number
        truth = drop_parts(part, cell.bin, parts, seed=one)
        scan = synthesize(cell, part, truth, seed=one)
        if number == 0:
            localize(scan, part, cell, seed=one)
        began = time.perf_counter()
        found = localize(scan, part, cell, seed=one)
        errors["seconds"].append(time.perf_counter() - began)
        compare(part, truth, found, counts, errors)
    return {"counts": counts, **errors}


def compare(
    part: Part,
    truth: Sequence[pin.SE3],
    found: Sequence[Detection],
    counts: dict[str, int],
    errors: dict[str, list[float]],
) -> None:
    """Add one scene to the counts and errors of `measure`."""
    left = list(truth)
    counts["parts"] += len(truth)
    for detection in found:
        T = detection.T_world_part
        off = [float(np.linalg.norm(one.translation - T.translation)) for one in left]
        if not off or min(off) > NEAR:
            counts["ghosts"] += 1
            continue
        nearest = left.pop(int(np.argmin(off)))
        tilt, roll = _turns(part, nearest.rotation.T @ T.rotation)
        if tilt > WRONG or (detection.roll_known and roll > WRONG):
            counts["wrong"] += 1
            continue
        errors["distance"].append(min(off))
        errors["tilt"].append(tilt)
        if detection.roll_known:
            errors["roll"].append(roll)
        else:
            counts["roll unknown"] += 1
    counts["missed"] += len(left)


def _turns(part: Part, R: np.ndarray) -> tuple[float, float]:
    """By how much the part's axis is tilted, and the part turned about it [rad]."""
    axis = np.asarray(part.symmetry.axis)
    tilt = float(np.arccos(np.clip(axis @ R @ axis, -1.0, 1.0)))
    roll = 2 * np.arctan2(float(axis @ pin.Quaternion(R).coeffs()[:3]), pin.Quaternion(R).w)
    step = 2 * np.pi / part.symmetry.fold if part.symmetry.fold else np.inf
    if not np.isfinite(step):
        return tilt, 0.0
    return tilt, float(abs((roll + step / 2) % step - step / 2))
