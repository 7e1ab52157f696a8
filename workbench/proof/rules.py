"""What a cell asks of a plan whatever stands around the robot: grasps as authored, and places."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats, Ints, Solid, pose_from_rpy
from workbench.model.part import Grasp, Part
from workbench.model.plan import ArmPlan, Leg, Plan, Violation
from workbench.model.scan import Detection
from workbench.proof.bodies import TURNS, gap_of, still_of, turned_pieces
from workbench.proof.form import HOLDING
from workbench.proof.places.lying import lying_violations
from workbench.proof.places.standing import standing_violations
from workbench.proof.robot import Tree
from workbench.proof.stages import tcp

IN_HAND, IN_HAND_TURN = 0.001, np.deg2rad(1.0)
"""[m, rad] How far the part in the hand may be from where scan and grasp put it, and the hand from
its place."""

ASIDE, ARC, TURNED = 0.002, 0.005, np.deg2rad(1.5)
"""[m, m, rad] How far a hand may be off a straight way at waypoints, and anywhere between them,
where joints that move in proportion lead it in an arc."""

OFTEN = 0.044
"""[rad] The sum of all joints' turns after which a hand is looked at again: within 1.2 m of an axis
its chord is then less than 0.3 mm off, by L^2 / 8 times that."""

STRETCH = 256
"""Places of a hand that are looked at together."""

NEARLY, FINE = 0.0005, 0.002
"""[m, rad] How much nearer or farther counts as the same at a turn; and the sum of all joints'
turns within which a hand moves by less than some 2 mm."""


def grasp_violations(cell: Cell, tree: Tree, plan: Plan, one: ArmPlan) -> Iterator[Violation]:
    """Whether an arm takes its part by a grasp that it may use, as authored, and to a place."""
    arm, part = cell.arm(one.arm), cell.part(plan.detections[one.detection].part)
    grasp = next((g for g in part.grasps if g.name == one.grasp), None)
    if grasp is None:
        yield Violation(f"the part has no grasp {one.grasp!r}", arm.name)
        return
    found = plan.detections[one.detection]
    if found.T_world_found is None and not cell.bin.gives(part, found.T_world_part):
        yield Violation("the part lies outside of the regions of interest", arm.name)
    if not grasp.is_enabled:
        yield Violation(f"grasp {grasp.name} is switched off", arm.name)
    if grasp.arms and arm.name not in grasp.arms:
        yield Violation(f"grasp {grasp.name} is for arm {' or '.join(grasp.arms)}", arm.name)
    if grasp.tool and grasp.tool != arm.tool.name:
        yield Violation(f"grasp {grasp.name} is for tool {grasp.tool}", arm.name)
    for leg in one.legs:
        if leg.name in HOLDING and abs(leg.opening - grasp.grip) > 1e-6:
            yield Violation(_opening(leg, grasp.grip), arm.name, leg.name)
        elif leg.name not in HOLDING and not _fits(leg.opening, grasp, arm, cell):
            yield Violation(_opening(leg, grasp.opening), arm.name, leg.name)
    if abs(one.leg("reach").opening - one.leg("approach").opening) > 1e-6:
        # Nothing is looked at between two legs.
        yield Violation("does not begin with its fingers as reach has them", arm.name, "approach")
    T_world_part = plan.detections[one.detection].T_world_part
    T_grasp, T_put = (
        tcp(tree, tree.rest, arm, np.asarray(one.leg(name).q[-1])) for name in ("approach", "place")
    )
    if not _same(T_grasp * one.T_tcp_part, T_world_part, IN_HAND, IN_HAND_TURN):
        yield Violation("the part is not where the hand closes", arm.name, "approach")
    if not _takes(arm, grasp, one.T_tcp_part.inverse()):
        yield Violation(f"the part is not in the hand as grasp {grasp.name} takes it", arm.name)
    turn = T_world_part.rotation @ grasp.T_part_tcp.rotation
    ways = {
        "approach": turn @ grasp.approach * grasp.approach_length,
        "extract": None,
        "place": None,
    }
    if grasp.retreat is not None:
        ways["extract"] = turn @ grasp.retreat * grasp.retreat_length
    for name, way in ways.items():
        yield from straight_violations(tree, arm, name, np.asarray(one.leg(name).q), way)
    if one.station:
        yield from standing_violations(cell, tree, plan, one)
        return
    places = (T * half for T in arm.Ts_world_place for half in _halves(arm))
    if not any(_same(T_put, T, IN_HAND, IN_HAND_TURN) for T in places):
        # Where the part really is in the hand, not where the plan says that it is.
        T_world_put = T_put * T_grasp.actInv(T_world_part)
        begins = tcp(tree, tree.rest, arm, np.asarray(one.leg("place").q[0])).translation
        came = T_put.translation - begins
        yield from lying_violations(arm, part, plan.detections[one.detection], T_world_put, came)


def roll_violations(cell: Cell, tree: Tree, plan: Plan, one: ArmPlan) -> Iterator[Violation]:
    """Whether all is right at every turn of the parts whose roll nobody knows.

    The walk keeps everything out of the room of all turns.  Here it is asked whether the hand holds
    the part at each of them, whether the part comes off what it lies on, and whether the place may
    have it.  Turns at which a part would lie deeper than `sink` in something are left out.
    """
    found = plan.detections[one.detection]
    arm, part = cell.arm(one.arm), cell.part(found.part)
    if not found.roll_known:
        if arm.needs_roll:
            yield Violation("its places need the roll of the part, which is not known", arm.name)
        yield from _held_violations(arm, part, found, one)
    if not all(other.roll_known for other in plan.detections):
        yield from _bed_violations(cell, tree, plan, one)


def _held_violations(arm: Arm, part: Part, found: Detection, one: ArmPlan) -> Iterator[Violation]:
    """Whether fingers, or a cup, are at the part, and not in it, however that is turned."""
    T_part_flange = (arm.tool.T_flange_tcp * one.T_tcp_part).inverse()
    wide = one.leg("extract").opening
    solids, before = [(solid, solid.T_owner_shape) for solid in arm.tool.body], None
    if arm.tool.fingers:
        solids, before = _fingers(arm, wide), _fingers(arm, wide + 2 * arm.tool.press)
    pieces = turned_pieces(part, found)
    T_world_flange = found.T_world_part * T_part_flange
    for turn in range(TURNS):
        places = [piece[min(turn, len(piece) - 1)] for piece in pieces]
        gaps = [
            min(gap_of((solid.shape, T_world_flange * T), place) for place in places)
            for solid, T in solids
        ]
        far = max(gaps) if arm.tool.fingers else min(gaps)
        # Before pads give way they meet nothing.
        deep = min(gaps) + arm.tool.press
        if before is not None:
            deep = min(
                gap_of((solid.shape, T_world_flange * T), place)
                for place in places
                for solid, T in before
            )
        if deep < -NEARLY or far > arm.tool.press + NEARLY:
            degrees = 360 * turn / TURNS
            problem = f"does not hold the part if it is turned by {degrees:.0f} deg about its axis"
            yield Violation(problem, arm.name, "approach", distance=min(far, deep))
            return


def _fingers(arm: Arm, opening: float) -> list[tuple[Solid, pin.SE3]]:
    """The fingers of an arm so far open [m], seen from its flange."""
    return [
        (one.solid, pin.SE3(np.eye(3), one.direction * opening / 2) * one.solid.T_owner_shape)
        for one in arm.tool.fingers
    ]


def _bed_violations(cell: Cell, tree: Tree, plan: Plan, one: ArmPlan) -> Iterator[Violation]:
    """Whether a part comes off what it lies on at every turn that it, or a neighbour, may have."""
    arm, policy = cell.arm(one.arm), cell.policy
    moves = _coming_off(tree, arm, np.asarray(one.leg("extract").q), policy.release)
    mine = turned_pieces(cell.part(plan.detections[one.detection].part),
                         plan.detections[one.detection])  # fmt: skip
    beds = [[(body.label, (body.shape, body.T_joint_body))] for body in still_of(cell, plan.scene)]
    for number, other in enumerate(plan.detections):
        if number != one.detection:
            places = turned_pieces(cell.part(other.part), other)
            beds += [[(f"part-{number + 1}", place) for place in piece] for piece in places]
    near = policy.near_margin
    far = near + policy.release + NEARLY
    label = f"part-{one.detection + 1}"
    close = [
        (k, turn, bed, gap)
        for k, piece in enumerate(mine)
        for turn, place in enumerate(piece)
        for bed in beds
        for gap in [min(gap_of(place, where, far) for _, where in bed)]
        if gap < far
    ]
    sunk = {(k, turn) for k, turn, bed, gap in close if len(bed) == 1 and gap < -policy.sink}
    rounds = {k for k, piece in enumerate(mine) if len(piece) == 1}
    impossible = {turn for k, turn in sunk if k not in rounds}
    if any(k in rounds for k, _ in sunk) or len(impossible) == TURNS:
        problem = "a part lies too deep in what it lies on at every turn: its pose is wrong"
        yield Violation(problem, arm.name, "extract")
        return
    for k, turn, bed, _ in close:
        if k not in rounds and turn in impossible:
            continue
        for name, where in bed:
            begins = gap_of(mine[k][turn], where, far)
            if begins < -policy.sink or begins >= far:
                continue
            keeps = min(near, begins - 2 * NEARLY)
            for T in moves:
                shape, place = mine[k][turn]
                gap = gap_of((shape, T * place), where, far)
                if gap < keeps:
                    problem = "a part does not come off what it lies on at every turn"
                    pair = (label, name)
                    yield Violation(problem, arm.name, "extract", pair=pair, distance=gap)
                    return


def _coming_off(tree: Tree, arm: Arm, path: Floats, release: float) -> list[pin.SE3]:
    """Motions of the hand in the world, some millimetre apart, until it is `release` [m] far."""
    first = tcp(tree, tree.rest, arm, path[0])
    moves: list[pin.SE3] = []
    for q, after in pairwise(path):
        count = 1 + int(np.abs(after - q).sum() / FINE)
        for share in np.arange(1, count + 1) / count:
            T = tcp(tree, tree.rest, arm, q + share * (after - q))
            moves.append(T * first.inverse())
            if np.linalg.norm(T.translation - first.translation) >= release:
                return moves
    return moves


def pair_violations(cell: Cell, plan: Plan) -> Iterator[Violation]:
    """Whether two arms may take parts of one kind by these two grasps, in this order."""
    for number, first in enumerate(plan.arms):
        for second in plan.arms[number + 1 :]:
            kinds = [plan.detections[one.detection].part for one in (first, second)]
            library = cell.part(kinds[0]).library
            if kinds[0] == kinds[1] and not library.allows(first.grasp, second.grasp):
                yield Violation(f"grasps {first.grasp} and {second.grasp} are no pair of the part")


def _opening(leg: Leg, wanted: float) -> str:
    return f"fingers at {leg.opening * 1e3:.1f} mm, the grasp says {wanted * 1e3:.1f} mm"


def _fits(opening: float, grasp: Grasp, arm: Arm, cell: Cell) -> bool:
    """Whether fingers may be so far open [m]: as the grasp says, or less by the policy."""
    air, least = cell.policy.least_air, grasp.opening
    if air is not None and arm.tool.fingers:
        least = min(grasp.opening, grasp.grip + 2 * air)
    return least - 1e-6 <= opening <= grasp.opening + 1e-6


def _same(T: pin.SE3, other: pin.SE3, far: float, turn: float) -> bool:
    off = T.actInv(other)
    is_near = float(np.linalg.norm(off.translation)) <= far
    return is_near and float(np.linalg.norm(pin.log3(off.rotation))) <= turn


def _halves(arm: Arm) -> tuple[pin.SE3, ...]:
    """Turns of a hand that change nothing: two fingers can change places."""
    half = pose_from_rpy((0, 0, 0), (0, 0, np.pi))
    return (pin.SE3.Identity(), half) if len(arm.tool.fingers) == 2 else (pin.SE3.Identity(),)


def _takes(arm: Arm, grasp: Grasp, T_part_tcp: pin.SE3) -> bool:
    """Whether a hand takes a part as a grasp says: turned about z, tilted about y, slid along x.

    The grasp leaves so much free: T_part_tcp = T_grasp * slide(x) * tilt(y) * turn(z).
    """
    for half in _halves(arm):
        off = grasp.T_part_tcp.actInv(T_part_tcp * half)
        slide, R = off.translation, off.rotation
        tilt, turn = np.arctan2(R[0, 2], R[2, 2]), np.arctan2(R[1, 0], R[1, 1])
        free = np.array([abs(slide[0]) - grasp.slide, 0.0, 0.0]).clip(min=0.0)
        is_there = np.linalg.norm([free[0], slide[1], slide[2]]) <= IN_HAND
        is_tilted = abs(tilt) <= grasp.tilt + IN_HAND_TURN and abs(R[1, 2]) <= np.sin(IN_HAND_TURN)
        if is_there and is_tilted and abs(turn) <= grasp.free_rotation + IN_HAND_TURN:
            return True
    return False


def straight_violations(
    tree: Tree, arm: Arm, leg: str, path: Floats, way: Floats | None = None
) -> Iterator[Violation]:
    """Whether a hand goes straight, and, where `way` (3,) [m] in the world is given, that way.

    Joints between two waypoints (m, n) [rad] move in proportion, and the hand then on a curve: it
    is looked at so often that it is less than 0.3 mm off the chord of two neighbours.
    """
    rows, at = _dense(path)
    start = tcp(tree, tree.rest, arm, rows[0])
    gone = tcp(tree, tree.rest, arm, rows[-1]).translation - start.translation
    if way is not None and np.linalg.norm(gone - way) > ASIDE:
        yield Violation("does not go the way that the grasp says", arm.name, leg)
    length = float(np.linalg.norm(gone))
    along = gone / length if length > 0 else gone
    farthest, is_waypoint = -np.inf, np.diff(at, prepend=-1).astype(bool)
    for k in range(0, len(rows), STRETCH):
        poses = [tcp(tree, tree.rest, arm, q) for q in rows[k : k + STRETCH]]
        off = np.array([T.translation for T in poses]) - start.translation
        far = off @ along
        aside = np.linalg.norm(off - far[:, None] * along, axis=1)
        most = np.maximum.accumulate(np.maximum(far, farthest))
        # The cosine of a turn is (trace - 1) / 2.
        turns = np.array([T.rotation for T in poses])
        cosines = (np.einsum("ij,kij->k", start.rotation, turns) - 1.0) / 2.0
        is_off = aside > np.where(is_waypoint[k : k + STRETCH], ASIDE, ARC)
        is_off |= (most - far > ASIDE) | (cosines < np.cos(TURNED))
        if is_off.any():
            yield Violation("is not straight", arm.name, leg, int(at[k + is_off.argmax()]))
            return
        farthest = most[-1]


def _dense(path: Floats) -> tuple[Floats, Ints]:
    """Configurations (k, n) [rad] along waypoints (m, n), and the waypoint (k,) before each."""
    steps = np.diff(path, axis=0)
    counts = np.ceil(np.abs(steps).sum(axis=1) / OFTEN).astype(int).clip(min=1)
    at = np.repeat(np.arange(len(steps)), counts)
    shares = np.concatenate([np.arange(count) / count for count in counts])
    rows = path[at] + shares[:, None] * steps[at]
    return np.vstack([rows, path[-1]]), np.append(at, len(steps) - 1)
