"""Whether a part of unknown roll is taken safely at every turn that it may have."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats, Shape, Solid
from workbench.model.messages.proofs import ProofText
from workbench.model.part import Part
from workbench.model.plan import ArmPlan, Plan, Violation
from workbench.model.scan import Detection
from workbench.proof.claims.scene import roll_turns, still_of, turned_pieces, turned_rooms
from workbench.proof.claims.stages import in_hand, tcp
from workbench.proof.claims.table import least_distance_allowed
from workbench.proof.engine.robot import Tree
from workbench.proof.engine.shapes import gap_of, hull, least_gap

SAME_DISTANCE, NARROW_SET = 0.0005, 0.0004
"""[m, rad] Difference of distances at two rolls that counts as equal; and the sum of joint motions
within which a hand, up to 1.2 m from an axis, moves by less than 0.5 mm."""


def roll_violations(cell: Cell, tree: Tree, plan: Plan, arm_plan: ArmPlan) -> Iterator[Violation]:
    """Whether a hand holds its part, and all is right at every turn where nobody knows its roll.

    People have authored how a grasp of a library holds a part; a found grip is checked here.  The
    walk keeps everything out of the room of all turns.  Here it is asked whether the hand holds
    the part at each of them; whether the part comes off what it lies on, and whether the place
    may have it.  Turns at which a part would lie deeper than `sink` in something are left out.
    """
    found = plan.detections[arm_plan.detection]
    arm, part = cell.arm(arm_plan.arm), cell.part(found.part)
    if not found.roll_known and arm.needs_roll:
        yield Violation(ProofText.PLACES_NEED_ROLL(), arm.name)
    if not found.roll_known or arm_plan.found is not None:
        T_tcp_part = in_hand(cell, tree, plan, arm_plan)
        yield from _held_violations(arm, part, found, arm_plan, T_tcp_part)
    if not all(other.roll_known for other in plan.detections):
        yield from _bed_violations(cell, tree, plan, arm_plan)


def _held_violations(
    arm: Arm, part: Part, found: Detection, arm_plan: ArmPlan, T_tcp_part: pin.SE3
) -> Iterator[Violation]:
    """Whether fingers, or a cup, are at the part, and not in it, however that is turned."""
    T_part_flange = (arm.tool.T_flange_tcp * T_tcp_part).inverse()
    wide = arm_plan.leg("extract").opening
    solids, wider = [(solid, solid.T_owner_shape) for solid in arm.tool.body], None
    if arm.tool.fingers:
        # The pieces are larger than the part by its tolerance.
        press = arm.tool.press + (part.tolerance or 0.0)
        solids, wider = _fingers(arm, wide), _fingers(arm, wide + 2 * press)
    pieces, count = turned_pieces(part, found), roll_turns(part, found)
    T_world_flange = found.T_world_part * T_part_flange
    hand = [(solid.shape, T_world_flange * T) for solid, T in solids]
    before = [(solid.shape, T_world_flange * T) for solid, T in wider or ()]
    # What is the same at every turn is measured once.
    rounds = [piece[0] for piece in pieces if len(piece) == 1]
    nearest = [least_gap(body, rounds) for body in hand]
    deepest = min((least_gap(body, rounds) for body in before), default=np.inf)
    for turn in range(count):
        places = [piece[turn] for piece in pieces if len(piece) > 1]
        gaps = [least_gap(body, places, far) for body, far in zip(hand, nearest, strict=True)]
        far = max(gaps) if arm.tool.fingers else min(gaps)
        # Before pads give way they meet nothing.
        deep = min(gaps) + arm.tool.press
        if wider is not None:
            deep = min(least_gap(body, places, deepest) for body in before)
        # What pads give way by differs from turn to turn; otherwise the fingers lie on the part.
        away = SAME_DISTANCE if found.roll_known else arm.tool.press + SAME_DISTANCE
        if deep < -SAME_DISTANCE or far > away:
            problem = ProofText.NOT_HELD(angle=2 * np.pi * turn / count)
            yield Violation(problem, arm.name, "approach", distance=min(far, deep))
            return


def _fingers(arm: Arm, opening: float) -> list[tuple[Solid, pin.SE3]]:
    """The fingers of an arm at an opening [m], in the frame of its flange."""
    return [
        (
            finger.solid,
            pin.SE3(np.eye(3), finger.direction * opening / 2) * finger.solid.T_owner_shape,
        )
        for finger in arm.tool.fingers
    ]


def _bed_violations(cell: Cell, tree: Tree, plan: Plan, arm_plan: ArmPlan) -> Iterator[Violation]:
    """Whether a part comes off what it lies on at every turn that it, or a neighbour, may have."""
    arm, policy, found = cell.arm(arm_plan.arm), cell.policy, plan.detections[arm_plan.detection]
    part = cell.part(found.part)
    mine, count = turned_pieces(part, found), roll_turns(part, found)
    beds = [[(body.label, (body.shape, body.T_joint_body))] for body in still_of(cell, plan.scene)]
    for number, other in enumerate(plan.detections):
        if number != arm_plan.detection:
            places = turned_pieces(cell.part(other.part), other)
            beds += [[(f"part-{number + 1}", place) for place in piece] for piece in places]
    far = policy.near_margin + policy.release + SAME_DISTANCE
    # The room of all turns is no farther from a bed than the piece at any of them.
    near_beds = [
        [bed for bed in beds if any(not gap_of(room, where, far) >= far for _, where in bed)]
        for room in turned_rooms(part, found)
    ]
    close = [
        (k, turn, bed, gaps)
        for k, piece in enumerate(mine)
        for turn, place in enumerate(piece)
        for bed in near_beds[k]
        for gaps in [[gap_of(place, where, far) for _, where in bed]]
        if not min(gaps) >= far
    ]
    sunk = {(k, turn) for k, turn, bed, gaps in close if len(bed) == 1 and gaps[0] < -policy.sink}
    rounds = {k for k, piece in enumerate(mine) if len(piece) == 1}
    impossible = {turn for k, turn in sunk if k not in rounds}
    if any(k in rounds for k, _ in sunk) or len(impossible) == count:
        yield Violation(ProofText.TOO_DEEP_ANY_TURN(), arm.name, "extract")
        return
    lift = _Lift(tree, arm, np.asarray(arm_plan.leg("extract").q), policy.release)
    for k, turn, bed, gaps in close:
        if k not in rounds and turn in impossible:
            continue
        for (name, where), begins in zip(bed, gaps, strict=True):
            if begins < -policy.sink or begins >= far:
                continue
            keeps = min(policy.near_margin, least_distance_allowed(begins))
            gap = lift.too_near(mine[k][turn], where, begins, keeps)
            if gap is not None:
                problem, pair = ProofText.STAYS_ON(), (f"part-{arm_plan.detection + 1}", name)
                yield Violation(problem, arm.name, "extract", pair=pair, distance=gap)
                return


class _Lift:
    """Motions of a hand in the world along a path (m, n) [rad], until it is `release` [m] far."""

    def __init__(self, tree: Tree, arm: Arm, path: Floats, release: float) -> None:
        first = tcp(tree, tree.rest, arm, path[0])
        self._moves = [pin.SE3.Identity()]
        for q, after in pairwise(path):
            count = 1 + int(np.abs(after - q).sum() / NARROW_SET)
            for share in np.arange(1, count + 1) / count:
                T = tcp(tree, tree.rest, arm, q + share * (after - q))
                self._moves.append(T * first.inverse())
                if np.linalg.norm(T.translation - first.translation) >= release:
                    break
            else:
                continue
            break
        steps = [earlier.actInv(later) for earlier, later in pairwise(self._moves)]
        self._turns = np.array([np.linalg.norm(pin.log3(T.rotation)) for T in steps])

    def too_near(
        self, body: tuple[Shape, pin.SE3], bed: tuple[Shape, pin.SE3], begins: float, keeps: float
    ) -> float | None:
        """A distance [m] at which a lifted body comes nearer to its bed than it `keeps` [m].

        No point of the body moves farther than `gone`: motions that this clears are not measured.
        """
        (shape, T), around = body, hull(body[0])
        centre = T.act(around.centre)
        places = np.array([move.act(centre) for move in self._moves])
        moved = np.linalg.norm(np.diff(places, axis=0), axis=1) + self._turns * around.radius
        gone = np.append(0.0, np.cumsum(moved))
        k, gap = 0, begins
        while k < len(gone) - 1:
            k = max(k + 1, int(np.searchsorted(gone, gone[k] + gap - keeps)) - 1)
            # Farther than this it stays away from its bed on the rest.
            far = keeps + gone[-1] - gone[k] + NARROW_SET
            gap = gap_of((shape, self._moves[k] * T), bed, far)
            if gap < keeps:
                return gap
        return None
