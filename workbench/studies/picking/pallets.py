"""Pallets in layers filled from simulated piles, and whether physics has the stacks stand."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from workbench.app.picking.pallets import at_rest, boxes_around, pallets_of
from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.stations import put_down
from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.scan import Detection
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.stacks import let_go

SEEDS = 1000
"""Piles of a pallet have seeds of their own, this many apart from those of the next."""

MOST_PILES = 3
"""This many piles in a row without a plan end a pallet."""

LEANS, LIES_OFF = np.deg2rad(2.0), 0.004
"""[rad, m] A part that leans more, or lies farther from where it was put and fallen to, is off."""


@dataclass(frozen=True, slots=True)
class Case:
    """One pallet: each pile has `parts` parts of a kind at known poses, of which one is taken.

    `off` [m] is the standard deviation of the actual release position along x and y.
    """

    cell: str
    part: str
    parts: int
    seed: int
    off: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Filled:
    """What came of a pallet.

    Of its `places` this many were filled with `parts`; `ends` says why there are no more, empty
    where it is full.  `piles` were checked, of which `unplanned` brought no plan.  Of the parts
    `off` do not lie where they were put and have fallen to; `shift` [m] and `lean` [rad] are the
    most of all.
    """

    seed: int
    places: int
    parts: int
    piles: int
    unplanned: int
    off: int
    shift: float
    lean: float
    ends: str


def fill_pallets(case: Case) -> Filled:
    """Fill the pallets of a cell, and let MuJoCo say how the parts lie in the end.

    Raises:
        InputError: the cell has no pallet in layers.
    """
    cell = read_cell(case.cell)
    places = sum(pallet_fill.places for pallet_fill in pallets_of(cell, ()))
    if not places:
        raise InputError(f"cell {cell.name} has no pallet in layers: a grid of three numbers")
    placed: tuple[Detection, ...] = ()
    piles = unplanned = failed = 0
    ends = ""
    while (
        any(pallet_fill.layer for pallet_fill in pallets_of(cell, placed)) and failed < MOST_PILES
    ):
        seed = case.seed * SEEDS + piles
        pile = pile_of(cell, case.part, case.parts, seed=seed)
        piles += 1
        result = plan_pick(cell, pile, "study", obstacles=boxes_around(cell, placed), seed=seed)
        if result.plan is None or result.proof is None or not result.proof.holds:
            unplanned, failed = unplanned + 1, failed + 1
            ends = str(result.verdict)
            if result.proof is not None and result.proof.violations:
                ends = str(result.proof.violations[0])
            continue
        failed, ends = 0, ""
        placed += put_down(cell, result.plan)
    off, shift, lean = _off(cell, placed, case)
    return Filled(case.seed, places, len(placed), piles, unplanned, off, shift, lean, ends)


def _off(cell: Cell, placed: Sequence[Detection], case: Case) -> tuple[int, float, float]:
    """How many parts lie otherwise than where they were let go of and should have fallen to."""
    if not placed:
        return 0, 0.0, 0.0
    generator = np.random.default_rng([case.seed, 7])
    beside = [np.append(generator.normal(0.0, case.off, 2), 0.0) for _ in placed]
    released = [
        (cell.part(detection.part), pin.SE3(T.rotation, T.translation + away))
        for detection, away in zip(placed, beside, strict=True)
        for T in [detection.T_world_part]
    ]
    shifts: list[float] = []
    leans: list[float] = []
    rests = zip(let_go(cell, released), at_rest(cell, placed), beside, strict=True)
    for lies, meant, away in rests:
        shifts.append(float(np.linalg.norm(lies.translation - meant.translation - away)))
        cosine = lies.rotation[2] @ meant.rotation[2]
        leans.append(float(np.arccos(np.clip(cosine, -1.0, 1.0))))
    is_off = (np.array(shifts) > LIES_OFF) | (np.array(leans) > LEANS)
    return int(is_off.sum()), max(shifts), max(leans)


def summary(results: Sequence[Filled]) -> dict[str, Any]:
    """The report of all pallets."""
    return {
        "pallets": len(results),
        "full": sum(result.parts == result.places for result in results),
        "stand": sum(result.off == 0 for result in results),
        "places": sum(result.places for result in results),
        "parts": sum(result.parts for result in results),
        "off": sum(result.off for result in results),
        "piles": sum(result.piles for result in results),
        "unplanned": sum(result.unplanned for result in results),
        "shift_mm": max((result.shift for result in results), default=0.0) * 1000,
        "lean_deg": float(np.rad2deg(max((result.lean for result in results), default=0.0))),
        "ends": sorted({result.ends for result in results if result.ends}),
    }
