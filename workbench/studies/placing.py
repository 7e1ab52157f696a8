"""Whether parts lie in the hand as the error budget of a pick says: MuJoCo grips them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
import pinocchio as pin

from workbench.app.runtime.work import find_parts
from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.candidate import Candidate
from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, shift_and_turn
from workbench.model.part import TURN_MARK, Part, PartPlace
from workbench.model.scan import Detection
from workbench.perception.matching.pose_error import pose_error
from workbench.perception.simulation.gripping import Gripping, HeldPart, Shaking
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize
from workbench.planning.collision.world import World
from workbench.planning.grasps.pads import has_pads
from workbench.planning.kinematics.quickness import hand_acceleration
from workbench.planning.picking.propose import propose
from workbench.planning.placing.budget import Budget, budget_of
from workbench.planning.placing.chance import CONFIDENCE, draw_errors, within
from workbench.planning.placing.sources import calibration_error, localization_error
from workbench.plugins.progress import Report, never, silent
from workbench.studies.cases import run_cases
from workbench.studies.localization import BUILDS, RIGHT_TURN, RIGHT_WITHIN

GRASPS_A_PART, TRIALS_A_GRASP = 4, 20
"""Grasps that are tried of a part as it lies, and how often each is."""

MOST_ROUNDS = 6
"""Of parts that fall in the place of those that came to nothing."""

SLIPS, TIPS, LOST = 0.001, float(np.deg2rad(2.0)), 0.02
"""Limits of a part's motion in the closed hand: from there on it slips [m], tips [rad], or is lost
[m]."""


STAYS = 0.0005, float(np.deg2rad(0.5))
"""[m, rad] A part that moves less once the bin is away lies by itself."""


@dataclass(frozen=True, slots=True)
class Case:
    """One part as it fell, and how it is gripped.

    `build` of the scanner that sees it, as in `localization`; `wider` multiplies the deviations
    of the localization, `force` [N] is that of each finger, `acceleration` [m/s2] None: as the
    arm's joints at home bring it about.
    """

    cell: str
    part: str
    seed: int
    build: str = "fine"
    wider: float = 1.0
    force: float = 20.0
    acceleration: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Gripped:
    """All grips of one part by one grasp: what was said, and what became of each.

    `chance` 0..1 is predicted, `shift` [m] and `turn` [rad] for `CONFIDENCE` of all picks.
    `shifts` (n,) [m] and `turns` (n,) [rad] were measured, infinite where the part is not in the
    hand; `is_right` says which are within the tolerances, `was_right` which were before the hand
    moved; `slipped`, `tipped`, `lost` and `missed` are counted.
    """

    grasp: str
    seed: int
    chance: float
    shift: float
    turn: float
    shifts: Floats
    turns: Floats
    is_right: tuple[bool, ...]
    was_right: tuple[bool, ...]
    slipped: int
    tipped: int
    lost: int
    missed: int


def measure(case: Case, grips: int, *, workers: int = 1, report: Report = silent) -> list[Gripped]:
    """Parts fall and are gripped until there are as many grips, seed after seed.

    Args:
        case: the first one.
        grips: at least this many, unless hardly any part can be gripped.
        workers: processes on this machine.
        report: progress.

    Raises:
        InputError: no arm of the cell has two fingers.
    """
    cell = read_cell(case.cell)
    if not any(has_pads(arm.tool) for arm in cell.arms):
        raise InputError(
            f"cell {cell.name}: no arm has a hand with two fingers, which is gripped by"
        )
    results: list[Gripped] = []
    seed = case.seed
    for _ in range(MOST_ROUNDS):
        left = grips - sum(len(result.shifts) for result in results)
        if left <= 0:
            break
        cases = [
            replace(case, seed=seed + k)
            for k in range(-(-left // (GRASPS_A_PART * TRIALS_A_GRASP)))
        ]
        seed += len(cases)
        for some in run_cases(grip_part, cases, workers=workers, report=report):
            results += some
    return results


def grip_part(case: Case) -> list[Gripped]:
    """Drop a part, look at it, and grip it again and again by some of the grasps that fit.

    Nothing comes of a part that is not found, that leans on the bin, or that no grasp fits.
    """
    seen = look_at(case)
    return [] if seen is None else _grip(case, *seen)


def look_at(case: Case) -> tuple[Cell, Part, Detection] | None:
    """Drop a part and find it: the cell with it, the part, and how it truly lies.

    None of one that is not found.
    """
    cell = _warm(case.cell, case.part, case.build)
    fallen = pile_of(cell, "", 1, seed=case.seed)
    scan = synthesize(cell, fallen, seed=case.seed, noise=BUILDS[case.build].noise)
    part, true = cell.part(fallen[0].part), fallen[0].T_world_part
    for found in find_parts(cell, {"scan": scan, "seed": case.seed}, silent, never).detections:
        far, turn = pose_error(
            part,
            true,
            found.T_world_part,
            roll_known=found.roll_known,
            roll_axis=found.roll_axis,
        )
        if far <= RIGHT_WITHIN and turn <= RIGHT_TURN and found.covariance is not None:
            covariance = found.covariance * case.wider**2
            return cell, part, replace(found, T_world_part=true, covariance=covariance)
    return None


def _grip(case: Case, cell: Cell, part: Part, lying: Detection) -> list[Gripped]:
    if not _lies_by_itself(cell, part, lying):
        return []
    rng = np.random.default_rng([case.seed, 1])
    fitting = [
        candidate
        for candidate in propose(World(cell, (lying,)))
        if candidate.verdict.is_ok and has_pads(cell.arm(candidate.arm).tool)
    ]
    once = list({candidate.grasp.name: candidate for candidate in fitting}.values())
    chosen = [once[k] for k in sorted(rng.permutation(len(once))[:GRASPS_A_PART])]
    covariance = calibration_error(cell.scanner, lying) + localization_error(lying)
    return [
        _by_one(
            case,
            cell,
            part,
            lying,
            candidate,
            draw_errors(covariance, each, (case.seed, 2 + number)),
        )
        for number, candidate in enumerate(chosen)
        for each in [GRASPS_A_PART * TRIALS_A_GRASP // len(chosen)]
    ]


def _lies_by_itself(cell: Cell, part: Part, lying: Detection) -> bool:
    T = lying.T_world_part
    tool = next(arm.tool for arm in cell.arms if has_pads(arm.tool))
    far, turn = shift_and_turn(T.actInv(Gripping(part, tool, T).settled()))
    return far <= STAYS[0] and turn <= STAYS[1]


def _by_one(
    case: Case, cell: Cell, part: Part, lying: Detection, candidate: Candidate, errors: Floats
) -> Gripped:
    arm = cell.arm(candidate.arm)
    budget = budget_of(cell, lying, candidate)
    place = budget.place or PartPlace(pin.SE3.Identity())
    a = hand_acceleration(cell, arm) if case.acceleration is None else case.acceleration
    shaking, T = Shaking(case.force, a), lying.T_world_part
    gripping = Gripping(part, arm.tool, T)
    T_tcp_meant = candidate.T_world_tcp.actInv(T)
    held: list[HeldPart] = []
    for error in errors:
        # The part lies where it came to rest; it is the hand that is off, by as much.
        off = pin.SE3(pin.exp3(error[3:]) @ T.rotation, T.translation + error[:3])
        T_world_tcp = T * off.inverse() * candidate.T_world_tcp
        held.append(gripping.grip(T_world_tcp, candidate.grasp.opening, shaking))
    shifts, turns = measure_offsets([grip.T_tcp_part for grip in held], T_tcp_meant, budget)
    closed = measure_offsets([grip.T_tcp_closed for grip in held], T_tcp_meant, budget)
    slips = [grip.slip for grip in held if grip.slip is not None]
    return Gripped(
        candidate.grasp.name,
        case.seed,
        budget.chance_at(place),
        budget.shift,
        budget.turn,
        shifts,
        turns,
        _are_right((shifts, turns), place),
        _are_right(closed, place),
        slipped=sum(SLIPS < far <= LOST for far, _ in slips),
        tipped=sum(turn > TIPS and far <= LOST for far, turn in slips),
        lost=sum(far > LOST for far, _ in slips),
        missed=len(held) - len(slips),
    )


def _are_right(off: tuple[Floats, Floats], place: PartPlace) -> tuple[bool, ...]:
    rows = zip(*off, strict=True)
    return tuple(within((np.array([a]), np.array([b])), place) == 1.0 for a, b in rows)


def measure_offsets(
    found: Sequence[pin.SE3 | None], T_tcp_meant: pin.SE3, budget: Budget
) -> tuple[Floats, Floats]:
    """How far parts lie from how they were meant to, (n,) [m] and (n,) [rad].

    Infinitely where they are not in the hand at all.
    """
    errors = np.full((len(found), 6), np.inf)
    R = T_tcp_meant.rotation
    for row, T in enumerate(found):
        if T is not None:
            errors[row, :3] = R.T @ (T.translation - T_tcp_meant.translation)
            errors[row, 3:] = R.T @ pin.log3(T.rotation @ R.T)
    is_there = np.isfinite(errors[:, 0])
    shifts, turns = np.full(len(found), np.inf), np.full(len(found), np.inf)
    shifts[is_there], turns[is_there] = budget.counted.off(errors[is_there])
    return shifts, turns


def summary(results: Sequence[Gripped]) -> dict[str, Any]:
    """What was said and what was measured, in all and by each entry of the library.

    Chances are means over the grips; lengths in m, angles in rad.
    """
    names = list(dict.fromkeys(entry_of(result.grasp) for result in results))
    return {
        "all": _row(results),
        "grasps": {
            name: _row([result for result in results if entry_of(result.grasp) == name])
            for name in sorted(names)
        },
    }


def entry_of(grasp: str) -> str:
    """The name of a grasp without the turn that a symmetry has made of it."""
    return grasp.split(TURN_MARK)[0]


def _row(results: Sequence[Gripped]) -> dict[str, Any]:
    if not results:
        return {"grips": 0}
    counts = np.array([len(result.shifts) for result in results])
    said = float(counts @ [result.chance for result in results] / counts.sum())
    right = float(np.mean([right for result in results for right in result.is_right]))
    inside = [
        np.mean(result.shifts <= result.shift) * np.array([1.0, 0.0])
        + np.mean(result.turns <= result.turn) * np.array([0.0, 1.0])
        for result in results
    ]
    shares = counts @ np.array(inside) / counts.sum()
    return {
        "grips": int(counts.sum()),
        "predicted": said,
        "measured": right,
        "difference": said - right,
        "closed": float(np.mean([right for result in results for right in result.was_right])),
        "stated": CONFIDENCE,
        "within_shift": float(shares[0]),
        "within_turn": float(shares[1]),
        **{
            name: sum(getattr(result, name) for result in results)
            for name in ("slipped", "tipped", "lost", "missed")
        },
    }


@lru_cache(maxsize=4)
def _warm(name: str, part: str, build: str) -> Cell:
    """The cell with that part and scanner, the part of its own that is meant where it has it."""
    cell = read_cell(name)
    own = tuple(known_part for known_part in cell.parts if known_part.name == part or not part)[:1]
    parts = own or (read_part(part),)
    deviation = BUILDS[build].deviation
    mount = cell.scanner if deviation is None else replace(cell.scanner, depth_noise=deviation)
    return replace(cell, parts=parts, scanner=mount)
