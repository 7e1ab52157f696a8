"""Whether parts mate as often as their error budgets say: MuJoCo inserts them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import pinocchio as pin

from workbench.formats.cells.reading import read_cell
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.model.recipes.joint import Joint, PlacingError
from workbench.model.recipes.kit import Insertion
from workbench.perception.simulation.inserting import Inserting, Push
from workbench.planning.collision.world import World
from workbench.planning.grasps.pads import has_pads
from workbench.planning.picking.propose import propose
from workbench.planning.placing.budget import budget_of
from workbench.planning.placing.chance import draw_errors
from workbench.planning.placing.mating import mate, mating_chance
from workbench.planning.placing.sources import scanner_error
from workbench.plugins.progress import Report, silent
from workbench.studies.placing import Case, look_at

FOUND_PARTS, GRASPS_A_PART, FALLS_A_PART = 6, 2, 4
"""Parts of each kind that are found, grasps of each, and falls for one that is."""

DOWN = (0.0, 0.0, -1.0)


@dataclass(frozen=True, slots=True)
class Pair:
    """Two kinds and their joint; `radius` [m] is that of the peg: the part, or its base."""

    part: str
    insertion: Insertion
    radius: float
    is_peg: bool


def _insertion(
    base: str,
    position: tuple[float, float, float],
    joint: Joint,
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Insertion:
    return Insertion(base, position, rpy, DOWN, 0.05, 1e-4, joint)


PAIRS = {
    "peg in ring": Pair(
        "keyed_cylinder",
        _insertion(
            "spacer",
            (0.0, 0.0, 0.03),
            Joint((0.0, 0.0, 0.01), 0.02, 0.02, 0.02, 0.001, 0.002, 0.0015),
        ),
        0.008,
        is_peg=True,
    ),
    "bolt in bracket hole": Pair(
        "bolt",
        _insertion(
            "bracket",
            (0.05, 0.0, 0.011),
            Joint((0.05, 0.0, 0.006), 0.03, 0.03, 0.006, 0.0008, 0.0015, 0.0012),
            (np.pi, 0.0, 0.0),
        ),
        0.008,
        is_peg=True,
    ),
    "cap on cylinder": Pair(
        "spacer",
        _insertion(
            "keyed_cylinder",
            (0.0, 0.0, 0.038),
            Joint((0.0, 0.0, 0.04), 0.012, 0.012, 0.012, 0.0006, 0.002, 0.002),
        ),
        0.015,
        is_peg=False,
    ),
}
"""Joints whose parts err as shipped parts do: the fits are made up."""


PUSH = Push(force=50.0, friction=0.2, stiffness=3000.0)


@dataclass(frozen=True, slots=True)
class Inserts:
    """Which insertions: of `pair`, with all errors `wider` times as large.

    `is_rigid`: the hand does not give way.
    """

    cell: str
    pair: str
    count: int
    seed: int
    wider: float = 1.0
    is_rigid: bool = False
    push: Push = PUSH


@dataclass(frozen=True, slots=True)
class Mated:
    """The share of insertions that mate, 0..1: as `predicted` of budgets, and as `measured`.

    `by_rule` is that by `mate` for the very errors drawn, and `otherwise` the share of insertions
    that end otherwise than it says.
    """

    pair: str
    count: int
    predicted: float
    by_rule: float
    measured: float
    otherwise: float


def insert_parts(case: Inserts, report: Report = silent) -> Mated:
    """Insert parts with errors drawn from the budgets of parts found and grasps that fit.

    Raises:
        InputError: no such pair, or no grasp fits its parts.
    """
    if case.pair not in PAIRS:
        raise InputError(f"{case.pair!r:.60} is no joint of the study: {', '.join(PAIRS)}")
    pair = PAIRS[case.pair]
    insertion = pair.insertion
    joint = insertion.joint
    assert joint is not None
    if case.is_rigid:
        joint = replace(joint, compliance=0.0)
        insertion = replace(insertion, joint=joint)
    scanner = scanner_error(read_cell(case.cell).scanner) * case.wider**2
    of_part, of_base = (
        [_widen(error, case.wider) for error in errors_of(case.cell, kind, case.seed)]
        for kind in (pair.part, insertion.base)
    )
    rng = np.random.default_rng([case.seed, 2])
    chosen = rng.integers(0, (len(of_part), len(of_base)), (case.count, 2)).tolist()
    chances = {
        (i, j): mating_chance(insertion, of_part[i], of_base[j], scanner)
        for i, j in sorted({(i, j) for i, j in chosen})
    }
    turned = draw_errors(scanner, case.count, case.seed + 1)
    inserting = Inserting(insertion, pair.radius, case.push, is_peg=pair.is_peg)
    rules: list[bool] = []
    found: list[bool] = []
    for number, (i, j) in enumerate(chosen):
        report(number / case.count, case.pair)
        part, base = (
            error.by_scanner @ turned[number]
            + draw_errors(error.covariance, 1, case.seed + 2 * number + which)[0]
            for which, error in ((2, of_part[i]), (3, of_base[j]))
        )
        rules.append(bool(mate(insertion, part[None], base[None])[0]))
        found.append(inserting.insert(_motion(base), _motion(part)).is_mated(joint))
    return Mated(
        case.pair,
        case.count,
        float(np.mean([chances[i, j] for i, j in chosen])),
        float(np.mean(rules)),
        float(np.mean(found)),
        float(np.mean(np.array(rules) != np.array(found))),
    )


@lru_cache(maxsize=16)
def errors_of(cell_name: str, kind: str, seed: int) -> Sequence[PlacingError]:
    """How far parts of a kind may be off that fall, are found in a scan, and gripped.

    Raises:
        InputError: none is found that a grasp fits.
    """
    found: list[PlacingError] = []
    for look in range(FOUND_PARTS * FALLS_A_PART):
        if len(found) >= FOUND_PARTS * GRASPS_A_PART:
            break
        seen = look_at(Case(cell_name, kind, seed + look))
        if seen is None:
            continue
        cell, _, lying = seen
        fitting = {
            candidate.grasp.name: candidate
            for candidate in propose(World(cell, (lying,)))
            if candidate.verdict.is_ok and has_pads(cell.arm(candidate.arm).tool)
        }
        some = np.random.default_rng([seed, look]).permutation(sorted(fitting))[:GRASPS_A_PART]
        found += [budget_of(cell, lying, fitting[name]).error for name in some.tolist()]
    if not found:
        raise InputError(f"{kind}: no part was found that a grasp of {cell_name} fits")
    return found


def _widen(error: PlacingError, times: float) -> PlacingError:
    return PlacingError(error.by_scanner, error.covariance * times**2)


def _motion(error: Floats) -> pin.SE3:
    """What is off by an error (6,) [m, rad], in its own frame."""
    return pin.SE3(pin.exp3(error[3:]), error[:3])
