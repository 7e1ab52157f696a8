"""The error budget of a pick: how far a part may lie from its target pose, and why."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType

import numpy as np
import pinocchio as pin

from workbench.model.candidate import Candidate
from workbench.model.cell import Cell, Tool
from workbench.model.derived.assembling import insertion_of
from workbench.model.derived.by_tcp import by_taking
from workbench.model.geometry import Floats, frozen, motions_moved, own
from workbench.model.messages.grasps import BudgetText
from workbench.model.messages.message import Message
from workbench.model.part import Part, PartPlace
from workbench.model.recipes.joint import PlacingError
from workbench.model.recipes.kit import Insertion
from workbench.model.scan import Detection
from workbench.planning.grasps.grasp_check import GraspChecker
from workbench.planning.placing.chance import (
    CONFIDENCE,
    DRAWS,
    Counted,
    draw_errors,
    select_counted,
    within,
)
from workbench.planning.placing.contact import Grip, cup_grip, finger_grip
from workbench.planning.placing.mating import mating_chance
from workbench.planning.placing.sources import (
    calibration_error,
    localization_error,
    moves_by_scanner,
    scanner_error,
)

CALIBRATION, LOCALIZATION, GRIP = (
    BudgetText.CALIBRATION,
    BudgetText.LOCALIZATION,
    BudgetText.GRIP,
)

ALONG = {
    True: (BudgetText.ACROSS_PADS, BudgetText.ALONG_TRAVEL, BudgetText.ALONG_TOOL),
    False: (BudgetText.ACROSS_TOOL, BudgetText.ACROSS_TOOL, BudgetText.ALONG_TOOL),
}
ABOUT = {
    True: (BudgetText.ABOUT_PADS, BudgetText.ABOUT_TRAVEL, BudgetText.ABOUT_TOOL),
    False: (BudgetText.ABOUT_ACROSS, BudgetText.ABOUT_ACROSS, BudgetText.ABOUT_TOOL),
}
"""Words for the axes of the hand, with fingers and without."""

NO_BASES: Mapping[str, PlacingError] = MappingProxyType({})


@dataclass(frozen=True, slots=True, eq=False)
class Budget:
    """How far a part may lie from its target pose, as predicted before the pick.

    `covariance` (6, 6) [m, rad] is of shifts of the part's origin, then of turns about it, along
    the axes of the hand: x across the pads, y along the fingers' travel, z along the tool.  It is
    the sum of `shares`, by where each comes from.  `R_part_hand` (3, 3), no unit, are these axes in
    the part's frame.  In `CONFIDENCE` of all picks the part is shifted by `shift` [m] or less and,
    counted by itself, turned by `turn` [rad] or less.  `largest` names what most of it comes from,
    and along or about which axis.  `chance` 0..1 is that of both within the tolerances of `place`,
    where there is one for the part; or, of a part that comes onto another one by a joint, of mating
    with that by `insertion`; `believed_chance` that before a scan has shown the base again, if one
    has.  `error` is all of it for what comes onto this part.
    """

    covariance: Floats
    shares: Mapping[BudgetText, Floats]
    R_part_hand: Floats
    shift: float
    turn: float
    largest: tuple[BudgetText, BudgetText]
    counted: Counted
    place: PartPlace | None
    chance: float | None
    error: PlacingError
    insertion: Insertion | None
    believed_chance: float | None = None

    def __post_init__(self) -> None:
        own(self, "covariance", "R_part_hand")

    def chance_at(self, place: PartPlace) -> float:
        """The chance, 0..1, that the part lies within the tolerances of a place."""
        return within(self._off(), place)

    @property
    def words(self) -> Message:
        """All of it in one sentence."""
        source, axis = self.largest
        error = BudgetText.PLACED(
            far=self.shift, turn=self.turn, sure=CONFIDENCE, source=source(), axis=axis()
        )
        if self.chance is None:
            return error
        if self.place is None:
            assert self.insertion is not None and self.insertion.joint is not None
            base = self.insertion.base
            known = {"error": error, "chance": self.chance, "base": base}
            mating = BudgetText.MATES(**known)
            if self.mates_seldom:
                mating = BudgetText.MATES_SELDOM(**known, share=self.insertion.joint.share)
            if self.believed_chance is None:
                return mating
            return BudgetText.SEEN_AGAIN(mating=mating, before=self.believed_chance, base=base)
        return BudgetText.WITHIN(
            error=error,
            chance=self.chance,
            tolerance=self.place.tolerance,
            turn_tolerance=self.place.turn_tolerance,
        )

    @property
    def mates_seldom(self) -> bool:
        """Whether fewer picks will mate than the joint asks for."""
        joint = None if self.insertion is None else self.insertion.joint
        return joint is not None and self.chance is not None and self.chance < joint.share

    def _off(self) -> tuple[Floats, Floats]:
        return off_of(self.covariance, self.R_part_hand, self.counted)


def budget_of(
    cell: Cell,
    detection: Detection,
    candidate: Candidate,
    bases: Mapping[str, PlacingError] = NO_BASES,
) -> Budget:
    """The error budget of a candidate; see `budget_by`."""
    T_part_tcp = detection.T_world_part.actInv(candidate.T_world_tcp)
    return budget_by(by_taking(cell, candidate), detection, candidate.arm, T_part_tcp, bases)


def budget_by(
    cell: Cell,
    detection: Detection,
    arm_name: str,
    T_part_tcp: pin.SE3,
    bases: Mapping[str, PlacingError] = NO_BASES,
) -> Budget:
    """The error budget of a grip.

    Robot and place count as exact.  The part is taken as lying by itself on something level.

    Args:
        cell: its scanner, its places for the part, the arm's tool by the TCP that takes it.
        detection: that is gripped.
        arm_name: whose hand grips it.
        T_part_tcp: of the grasp.
        bases: by their kinds, the errors of parts of the assembly that stand already.
    """
    arm = cell.arm(arm_name)
    part = cell.part(detection.part)
    T_world_part, tool = detection.T_world_part, arm.tool
    checker = _checker(part, tool)
    R_tcp_hand = np.eye(3) if checker.pads is None else np.asarray(checker.pads.R_tcp_closing)
    R_part_hand = T_part_tcp.rotation @ R_tcp_hand
    grip = _grip(checker, tool, T_part_tcp, T_world_part)
    to_hand = _to_hand(T_world_part, T_part_tcp, R_part_hand)
    to_part = motions_moved(-R_part_hand.T @ T_part_tcp.translation)
    before = {
        CALIBRATION: to_hand @ calibration_error(cell.scanner, detection) @ to_hand.T,
        LOCALIZATION: to_hand @ localization_error(detection) @ to_hand.T,
    }
    kept = {
        name: grip.keeps @ covariance_of @ grip.keeps.T for name, covariance_of in before.items()
    }
    kept[GRIP] = grip.covariance(before[CALIBRATION] + before[LOCALIZATION])
    shares = {
        name: frozen(to_part @ covariance_of @ to_part.T) for name, covariance_of in kept.items()
    }
    covariance = sum(shares.values(), np.zeros((6, 6)))
    turned = np.kron(np.eye(2), R_part_hand)
    by_scanner = to_part @ grip.keeps @ to_hand @ moves_by_scanner(cell.scanner, detection)
    rest = covariance - shares[CALIBRATION]
    error = PlacingError(turned @ by_scanner, turned @ rest @ turned.T)
    insertion = insertion_of(cell, part.name)
    places = arm.places_for(part.name) if insertion is None else ()
    place = places[0] if places else None
    what = select_counted(part, detection, place)
    off = off_of(covariance, R_part_hand, what)
    shift, turn = (float(np.quantile(samples, CONFIDENCE)) for samples in off)
    chance, believed = None if place is None else within(off, place), None
    if insertion is not None and insertion.joint is not None and insertion.base in bases:
        base, scanner = bases[insertion.base], scanner_error(cell.scanner)
        chance = mating_chance(insertion, error, base, scanner)
        if base.believed is not None:
            believed = mating_chance(insertion, error, base.believed, scanner)
    return Budget(
        covariance,
        shares,
        R_part_hand,
        shift,
        turn,
        _largest(shares, R_part_hand, what, place, bool(tool.fingers)),
        what,
        place,
        chance,
        error,
        insertion,
        believed,
    )


def kept_by_grip(
    cell: Cell, arm: str, part: str, T_world_part: pin.SE3, T_part_tcp: pin.SE3
) -> Floats:
    """What a hand keeps of the error of a part as it takes it: `error -> kept @ error` (6, 6).

    Errors are [m, rad] shifts of the part's origin, then turns about it, along the world's axes,
    before and after.

    Args:
        cell: that knows the `part` and the `arm` by these names.
        arm: see there.
        part: see there.
        T_world_part: how it lies.
        T_part_tcp: of the grasp.
    """
    tool = cell.arm(arm).tool
    checker = _checker(cell.part(part), tool)
    R_tcp_hand = np.eye(3) if checker.pads is None else np.asarray(checker.pads.R_tcp_closing)
    to_hand = _to_hand(T_world_part, T_part_tcp, T_part_tcp.rotation @ R_tcp_hand)
    grip = _grip(checker, tool, T_part_tcp, T_world_part)
    return np.linalg.inv(to_hand) @ grip.keeps @ to_hand


def _to_hand(T_world_part: pin.SE3, T_part_tcp: pin.SE3, R_part_hand: Floats) -> Floats:
    """From shifts of the origin, along the world's axes, to those at the TCP, along the hand's."""
    to_tcp = R_part_hand.T @ T_part_tcp.translation
    return motions_moved(to_tcp) @ np.kron(np.eye(2), (T_world_part.rotation @ R_part_hand).T)


def off_of(covariance: Floats, R_part_hand: Floats, what: Counted) -> tuple[Floats, Floats]:
    """Shifts (n,) [m] and turns (n,) [rad] of parts, of a covariance as that of `Budget`."""
    errors = draw_errors(covariance, DRAWS, 0) @ np.kron(np.eye(2), R_part_hand).T
    return what.off(errors)


@lru_cache(maxsize=8)
def _checker(part: Part, tool: Tool) -> GraspChecker:
    return GraspChecker(part, tool)


def _grip(checker: GraspChecker, tool: Tool, T_part_tcp: pin.SE3, T_world_part: pin.SE3) -> Grip:
    if checker.pads is not None:
        return finger_grip(checker, T_part_tcp, T_world_part)
    return cup_grip() if not tool.fingers else Grip(np.eye(6), np.empty((0, 6)), play=0.0)


def _largest(
    shares: Mapping[BudgetText, Floats],
    R_part_hand: Floats,
    what: Counted,
    place: PartPlace | None,
    has_fingers: bool,
) -> tuple[BudgetText, BudgetText]:
    """From where most of what counts comes, and along or about which axis of the hand.

    Shifts and turns are weighed by what a place allows.
    """
    allowed = place or PartPlace(pin.SE3.Identity())
    counts = np.eye(6)
    counts[:3] = motions_moved(R_part_hand.T @ what.point)[:3]
    for axis in what.free:
        along = R_part_hand.T @ axis
        counts[3:, 3:] = counts[3:, 3:] - np.outer(along, along @ counts[3:, 3:])
    weights = np.repeat([allowed.tolerance, allowed.turn_tolerance], 3)
    weighed = {
        name: np.diag(counts @ share @ counts.T) / weights**2 for name, share in shares.items()
    }
    name = max(weighed, key=lambda key: float(weighed[key].sum()))
    axis = int(np.argmax(weighed[name]))
    return name, (*ALONG[has_fingers], *ABOUT[has_fingers])[axis]
