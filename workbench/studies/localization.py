"""How well and how fast parts are found: seeded piles, simulated scans, true poses to compare.

`python -m workbench.studies.localization --scenes 40 --parts 2` prints the table.
"""

import json
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
import tyro
from rich.console import Console
from rich.progress import track
from rich.table import Table

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


@dataclass(frozen=True)
class Arguments:
    """Find the parts of seeded piles and print how well that went.

    cell: name or path of a cell.
    scenes: how many piles.
    parts: how many parts in each.
    seed: of the first pile; the others follow.
    json: print one JSON object instead of the table.
    """

    cell: str = "yumi"
    scenes: int = 40
    parts: int = 2
    seed: int = 0
    json: bool = False


def measure(arguments: Arguments) -> dict[str, Any]:
    """Scan and localize every pile once.

    One scene is localized before the clock starts, so that compiled code is loaded.

    Returns:
        `counts` by name, and lists: `distance` [m], `tilt` and `roll` [rad] of what was found
        right (roll only where it is said to be known), `seconds` a scene.
    """
    cell = read_cell(arguments.cell)
    part = cell.parts[0]
    counts = dict.fromkeys(("parts", "missed", "ghosts", "wrong", "roll unknown"), 0)
    errors: dict[str, list[float]] = {"distance": [], "tilt": [], "roll": [], "seconds": []}
    seeds = range(arguments.seed, arguments.seed + arguments.scenes)
    console = Console(stderr=True)
    for seed in track(seeds, "localizing", console=console, transient=True):
        truth = drop_parts(part, cell.bin, arguments.parts, seed=seed)
        scan = synthesize(cell, part, truth, seed=seed)
        if seed == arguments.seed:
            localize(scan, part, cell, seed=seed)
        began = time.perf_counter()
        found = localize(scan, part, cell, seed=seed)
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


def table(measured: dict[str, Any]) -> Table:
    """Medians and worst cases, and the counts below."""
    shown = Table(title="Localization")
    for column in ("what", "median", "90 %", "worst"):
        shown.add_column(column, justify="left" if column == "what" else "right")
    for name, key, factor in (
        ("position, mm", "distance", 1e3),
        ("axis, degrees", "tilt", np.rad2deg(1.0)),
        ("roll where known, degrees", "roll", np.rad2deg(1.0)),
        ("time a scene, ms", "seconds", 1e3),
    ):
        if measured[key]:
            row = np.percentile(np.array(measured[key]) * factor, [50, 90, 100])
            shown.add_row(name, *(f"{value:.2f}" for value in row))
    return shown


def main() -> None:
    """Entry point."""
    arguments = tyro.cli(Arguments)
    measured = measure(arguments)
    if arguments.json:
        json.dump(measured, sys.stdout)
        sys.stdout.write("\n")
        return
    console = Console()
    console.print(table(measured))
    console.print(", ".join(f"{count} {name}" for name, count in measured["counts"].items()))


if __name__ == "__main__":
    main()
