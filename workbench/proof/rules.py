"""What a cell asks of a plan whatever stands around the robot: limits, and grasps as authored."""

from collections.abc import Iterator
from itertools import pairwise

import coal
import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats, Ints, Shape, Solid, pose_from_rpy
from workbench.model.part import Grasp, Part
from workbench.model.plan import ArmPlan, Finding, Leg, Plan
from workbench.model.scan import Detection
from workbench.proof.bodies import TURNS, coal_shape, hull, still_of, turned_pieces
from workbench.proof.form import HOLDING
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

SOONEST = 1e-9
"""[s] Nothing moves within less, however little time a file gives it."""

ROUNDING = 1.001
"""What sums of rounded values may exceed a limit by."""


def range_findings(cell: Cell, arm: Arm, leg: Leg) -> Iterator[Finding]:
    """Joints beyond their limits on one leg.

    A joint between two waypoints is between its values there, so waypoints are enough.
    """
    lower, upper, _ = cell.robot.limits(arm.joints)
    q = np.asarray(leg.q)
    outside = np.argwhere((q < lower - 1e-9) | (q > upper + 1e-9))
    if len(outside):
        row, joint = outside[0].tolist()
        yield Finding(
            f"joint {arm.joints[joint]} at {np.rad2deg(q[row, joint]):.2f} deg is outside "
            f"{np.rad2deg(lower[joint]):.2f} to {np.rad2deg(upper[joint]):.2f} deg",
            arm.name,
            leg.name,
            row,
        )


def limit_findings(cell: Cell, arm: Arm, leg: Leg) -> Iterator[Finding]:
    """Limits of speeds, accelerations and fingers on one leg.

    Where a joint has to be when tells its mean speed between two waypoints; the real one is that
    somewhere.  So what is refused here breaks a limit for certain; in between, the controller keeps
    its own.
    """

    def finding(problem: str, row: int | None = None) -> Finding:
        return Finding(problem, arm.name, leg.name, row)

    velocity = cell.robot.limits(arm.joints)[2]
    q, t = np.asarray(leg.q), np.asarray(leg.t)
    if not cell.controller.motion.is_sendable(q):
        yield finding("holds a configuration finer than what can be sent")
    low, high = arm.tool.stroke
    if arm.tool.fingers and not low <= leg.opening <= high:
        yield finding(f"finger opening {leg.opening * 1e3:.1f} mm is outside the stroke")
    steps = np.diff(t)
    if t[0] != 0.0:
        yield finding("does not begin at 0 s")
    if np.any(steps <= 0):
        yield finding("has times that do not increase")
        return
    # A rounded corner is shorter than its waypoints make it look, never by more than its zone.
    means = np.diff(q, axis=0) / np.maximum(steps, SOONEST)[:, None]
    most = velocity * cell.policy.speed * ROUNDING / (1.0 - cell.policy.zone)
    too_fast = np.flatnonzero((np.abs(means) > most).any(axis=1))
    if len(too_fast):
        yield finding("is faster than the joints may turn", int(too_fast[0]))
    # From rest to rest: the speed at the first mean has been reached since the start, and so on.
    speeds = np.vstack([np.zeros(q.shape[1]), means, np.zeros(q.shape[1])])
    spans = np.concatenate([steps[:1], steps[:-1] + steps[1:], steps[-1:]]).clip(min=SOONEST)
    push = np.abs(np.diff(speeds, axis=0)) / spans[:, None]
    too_hard = np.flatnonzero(
        (push > arm.acceleration * ROUNDING / (1.0 - cell.policy.zone)).any(axis=1)
    )
    if len(too_hard):
        yield finding("asks for more acceleration than the arm has", max(int(too_hard[0]) - 1, 0))


def grasp_findings(cell: Cell, tree: Tree, plan: Plan, one: ArmPlan) -> Iterator[Finding]:
    """Whether an arm takes its part by a grasp that it may use, as authored, and to a place."""
    arm, part = cell.arm(one.arm), cell.part(plan.detections[one.detection].part)
    grasp = next((g for g in part.grasps if g.name == one.grasp), None)
    if grasp is None:
        yield Finding(f"the part has no grasp {one.grasp!r}", arm.name)
        return
    if not grasp.is_enabled:
        yield Finding(f"grasp {grasp.name} is switched off", arm.name)
    if grasp.arms and arm.name not in grasp.arms:
        yield Finding(f"grasp {grasp.name} is for arm {' or '.join(grasp.arms)}", arm.name)
    if grasp.tool and grasp.tool != arm.tool.name:
        yield Finding(f"grasp {grasp.name} is for tool {grasp.tool}", arm.name)
    for leg in one.legs:
        if leg.name in HOLDING and abs(leg.opening - grasp.grip) > 1e-6:
            yield Finding(_opening(leg, grasp.grip), arm.name, leg.name)
        elif leg.name not in HOLDING and not _fits(leg.opening, grasp, arm, cell):
            yield Finding(_opening(leg, grasp.opening), arm.name, leg.name)
    T_world_part = plan.detections[one.detection].T_world_part
    T_grasp, T_put = (
        tcp(tree, tree.rest, arm, np.asarray(one.leg(name).q[-1])) for name in ("approach", "place")
    )
    if not _same(T_grasp * one.T_tcp_part, T_world_part, IN_HAND, IN_HAND_TURN):
        yield Finding("the part is not where the hand closes", arm.name, "approach")
    if not _takes(arm, grasp, one.T_tcp_part.inverse()):
        yield Finding(f"the part is not in the hand as grasp {grasp.name} takes it", arm.name)
    turn = T_world_part.rotation @ grasp.T_part_tcp.rotation
    ways = {
        "approach": turn @ grasp.approach * grasp.approach_length,
        "extract": None,
        "place": None,
    }
    if grasp.retreat is not None:
        ways["extract"] = turn @ grasp.retreat * grasp.retreat_length
    for name, way in ways.items():
        yield from straight_findings(tree, arm, name, np.asarray(one.leg(name).q), way)
    places = (T * half for T in arm.Ts_world_place for half in _halves(arm))
    if not any(_same(T_put, T, IN_HAND, IN_HAND_TURN) for T in places):
        yield Finding("the hand opens where the arm has no place", arm.name, "place")


def roll_findings(cell: Cell, tree: Tree, plan: Plan, one: ArmPlan) -> Iterator[Finding]:
    """Whether all is right at every turn of the parts whose roll nobody knows.

    The walk keeps everything out of the room of all turns.  Here it is asked whether the hand holds
    the part at each of them, whether the part comes off what it lies on, and whether the place may
    have it.  Turns at which a part would lie deeper than `sink` in something are left out.
    """
    found = plan.detections[one.detection]
    arm, part = cell.arm(one.arm), cell.part(found.part)
    if not found.roll_known:
        if arm.needs_roll:
            yield Finding("its places need the roll of the part, which is not known", arm.name)
        yield from _held_findings(arm, part, found, one)
    if not all(other.roll_known for other in plan.detections):
        yield from _bed_findings(cell, tree, plan, one)


def _held_findings(arm: Arm, part: Part, found: Detection, one: ArmPlan) -> Iterator[Finding]:
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
            min(_gap((solid.shape, T_world_flange * T), place) for place in places)
            for solid, T in solids
        ]
        far = max(gaps) if arm.tool.fingers else min(gaps)
        # Before pads give way they meet nothing.
        deep = min(gaps) + arm.tool.press
        if before is not None:
            deep = min(
                _gap((solid.shape, T_world_flange * T), place)
                for place in places
                for solid, T in before
            )
        if deep < -NEARLY or far > arm.tool.press + NEARLY:
            degrees = 360 * turn / TURNS
            problem = f"does not hold the part if it is turned by {degrees:.0f} deg about its axis"
            yield Finding(problem, arm.name, "approach", distance=min(far, deep))
            return


def _fingers(arm: Arm, opening: float) -> list[tuple[Solid, pin.SE3]]:
    """The fingers of an arm so far open [m], seen from its flange."""
    return [
        (one.solid, pin.SE3(np.eye(3), one.direction * opening / 2) * one.solid.T_owner_shape)
        for one in arm.tool.fingers
    ]


def _bed_findings(cell: Cell, tree: Tree, plan: Plan, one: ArmPlan) -> Iterator[Finding]:
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
        for gap in [min(_gap(place, where, far) for _, where in bed)]
        if gap < far
    ]
    sunk = {(k, turn) for k, turn, bed, gap in close if len(bed) == 1 and gap < -policy.sink}
    rounds = {k for k, piece in enumerate(mine) if len(piece) == 1}
    impossible = {turn for k, turn in sunk if k not in rounds}
    if any(k in rounds for k, _ in sunk) or len(impossible) == TURNS:
        problem = "a part lies too deep in what it lies on at every turn: its pose is wrong"
        yield Finding(problem, arm.name, "extract")
        return
    for k, turn, bed, _ in close:
        if k not in rounds and turn in impossible:
            continue
        for name, where in bed:
            begins = _gap(mine[k][turn], where, far)
            if begins < -policy.sink or begins >= far:
                continue
            keeps = min(near, begins - 2 * NEARLY)
            for T in moves:
                shape, place = mine[k][turn]
                gap = _gap((shape, T * place), where, far)
                if gap < keeps:
                    problem = "a part does not come off what it lies on at every turn"
                    pair = (label, name)
                    yield Finding(problem, arm.name, "extract", pair=pair, distance=gap)
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


def _gap(one: tuple[Shape, pin.SE3], other: tuple[Shape, pin.SE3], far: float = np.inf) -> float:
    """The distance [m] of two bodies in the world, negative inside; at least `far` beyond that."""
    (shape, T), (bed, U) = one, other
    around, about = hull(shape), hull(bed)
    offset = U.rotation.T @ (T.act(around.centre) - U.act(about.centre))
    apart = np.linalg.norm(np.maximum(np.abs(offset) - about.half, 0.0)) - around.radius
    if apart >= far:
        return float(apart)
    return coal.distance(
        coal_shape(shape),
        coal.Transform3s(T.rotation, T.translation),
        coal_shape(bed),
        coal.Transform3s(U.rotation, U.translation),
        coal.DistanceRequest(),
        coal.DistanceResult(),
    )


def pair_findings(cell: Cell, plan: Plan) -> Iterator[Finding]:
    """Whether two arms may take parts of one kind by these two grasps, in this order."""
    for number, first in enumerate(plan.arms):
        for second in plan.arms[number + 1 :]:
            kinds = [plan.detections[one.detection].part for one in (first, second)]
            library = cell.part(kinds[0]).library
            if kinds[0] == kinds[1] and not library.allows(first.grasp, second.grasp):
                yield Finding(f"grasps {first.grasp} and {second.grasp} are no pair of the part")


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


def straight_findings(
    tree: Tree, arm: Arm, leg: str, path: Floats, way: Floats | None = None
) -> Iterator[Finding]:
    """Whether a hand goes straight, and, where `way` (3,) [m] in the world is given, that way.

    Joints between two waypoints (m, n) [rad] move in proportion, and the hand then on a curve: it
    is looked at so often that it is less than 0.3 mm off the chord of two neighbours.
    """
    rows, at = _dense(path)
    start = tcp(tree, tree.rest, arm, rows[0])
    gone = tcp(tree, tree.rest, arm, rows[-1]).translation - start.translation
    if way is not None and np.linalg.norm(gone - way) > ASIDE:
        yield Finding("does not go the way that the grasp says", arm.name, leg)
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
            yield Finding("is not straight", arm.name, leg, int(at[k + is_off.argmax()]))
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
