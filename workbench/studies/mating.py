"""Whether parts mate as often as their error budgets say: MuJoCo inserts them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

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
from workbench.plugins.progress import Report, silent, within
from workbench.studies.placing import Case, look_at
from workbench.studies.seen_bases import SeenAgain, motion_of, see_again

LOOKING = 0.5
"""Share of the progress for scans in which bases are seen again."""

MOST_SEEN = 100
"""Bases that are seen again, each in a scan of its own; more insertions share them."""

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

    `is_rigid`: the hand does not give way.  `looks_again`: the base is found again in a scan of its
    own, and its error is that of this sight, which nothing widens.
    """

    cell: str
    pair: str
    count: int
    seed: int
    wider: float = 1.0
    is_rigid: bool = False
    push: Push = PUSH
    looks_again: bool = False


@dataclass(frozen=True, slots=True)
class Mated:
    """The share of insertions that mate, 0..1: as `predicted` of budgets, and as `measured`.

    `by_rule` is that by `mate` for the very errors drawn, and `otherwise` the share of insertions
    that end otherwise than it says.  Where bases are found again `believed` is the share that is
    predicted without, and `unseen` of them were not found: nothing was put onto these.
    """

    pair: str
    count: int
    predicted: float
    by_rule: float
    measured: float
    otherwise: float
    believed: float | None = None
    unseen: int = 0


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
    bases = _bases(case, insertion.base, of_base, within(report, 0.0, LOOKING))
    if not bases:
        raise InputError(f"{case.pair}: no base was seen again")
    rng = np.random.default_rng([case.seed, 2])
    chosen = rng.integers(0, (len(of_part), len(bases)), (case.count, 2)).tolist()
    drawn = [(of_part[i], bases[j]) for i, j in chosen]
    stated = [(part, base.error) for part, base in drawn]
    turned = draw_errors(scanner, case.count, case.seed + 1)
    inserting = Inserting(insertion, pair.radius, case.push, is_peg=pair.is_peg)
    rules: list[bool] = []
    found: list[bool] = []
    for number, (of_part_drawn, of_base_drawn) in enumerate(drawn):
        report(LOOKING + (1.0 - LOOKING) * number / case.count, case.pair)
        part, base = (
            error.by_scanner @ turned[number]
            + draw_errors(error.covariance, 1, case.seed + 2 * number + which)[0]
            for which, error in ((2, of_part_drawn), (3, of_base_drawn.error))
        )
        if case.looks_again:
            base = of_base_drawn.error.by_scanner @ turned[number] + of_base_drawn.off
        rules.append(bool(mate(insertion, part[None], base[None])[0]))
        found.append(inserting.insert(motion_of(base), motion_of(part)).is_mated(joint))
    believed = [(part, base.believed) for part, base in stated if base.believed is not None]
    return Mated(
        case.pair,
        case.count,
        _predict(insertion, scanner, stated),
        float(np.mean(rules)),
        float(np.mean(found)),
        float(np.mean(np.array(rules) != np.array(found))),
        _predict(insertion, scanner, believed) if believed else None,
        min(case.count, MOST_SEEN) - len(bases) if case.looks_again else 0,
    )


def _predict(
    insertion: Insertion, scanner: Floats, pairs: Sequence[tuple[PlacingError, PlacingError]]
) -> float:
    """The share of parts and bases, by their errors, that mate; each pair is computed once."""
    known = {(id(part), id(base)): (part, base) for part, base in pairs}
    chances = {
        key: mating_chance(insertion, part, base, scanner) for key, (part, base) in known.items()
    }
    return float(np.mean([chances[id(part), id(base)] for part, base in pairs]))


def _bases(
    case: Inserts, kind: str, believed: Sequence[PlacingError], report: Report
) -> list[SeenAgain]:
    """The bases of some errors: as they are believed, or as a scan of each shows it again."""
    if not case.looks_again:
        return [SeenAgain(error, np.zeros(6)) for error in believed]
    count = min(case.count, MOST_SEEN)
    return see_again(case.cell, kind, believed, count=count, seed=case.seed, report=report)


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
