"""The world of one scan: one collision model whose attachments and margins change by phase."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats
from workbench.model.scan import Detection
from workbench.planning.bodies import Body, bodies_of, coal_shape, extent, pairs_of
from workbench.planning.bounds import close_pairs
from workbench.planning.chain import Chain, chain_of
from workbench.planning.kinematics import Kinematics


@dataclass(frozen=True, slots=True)
class Phase:
    """What is true during one leg.

    `moving`: the arms that move.  `held`: arm -> (detection, `T_tcp_part`).  `openings`: arm ->
    finger opening [m]; arms not named keep their fingers closed.  `absent`: detections that have left.
    `target`: the part that the tool is about to take.  `straight`: the tool may come as near as
    the policy's `near_margin`.
    """

    moving: frozenset[str]
    openings: Mapping[str, float] = field(default_factory=dict)
    held: Mapping[str, tuple[int, pin.SE3]] = field(default_factory=dict)
    absent: frozenset[int] = frozenset()
    target: int | None = None
    straight: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Contact:
    """A pair that is too close, or may come so within the motion asked about.

    `distance` [m] now (negative: penetration), `margin` [m] what it must keep, `move` [m] how
    much nearer the motion could bring it.
    """

    pair: tuple[str, str]
    distance: float
    margin: float
    move: float


class World:
    """The cell with the parts found, ready to answer "how close?" for any configuration.

    Lifetime: as long as cell and detections; `enter` changes what is attached, nothing is rebuilt.
    Concurrency: one thread at a time.
    """

    def __init__(self, cell: Cell, detections: tuple[Detection, ...]):
        self.cell = cell
        self.detections = detections
        self.kinematics = Kinematics(cell)
        self.chains: dict[str, Chain] = {arm.name: chain_of(cell, arm) for arm in cell.arms}
        self.checks = 0
        self._arm_index = {arm.name: index for index, arm in enumerate(cell.arms)}
        self._bodies = bodies_of(cell, self.kinematics, detections)
        self._make_geometry()
        self._make_tree()
        self._make_pairs()
        self.phase = Phase(frozenset())
        self.enter(Phase(frozenset(arm.name for arm in cell.arms)))

    # -- what is where ---------------------------------------------------------------------

    def arm(self, name: str) -> Arm:
        """The arm of that name."""
        return self.cell.arm(name)

    def enter(self, phase: Phase) -> None:
        """Attach, release and set margins for a leg."""
        self.phase = phase
        holders = {number: arm for arm, (number, _) in phase.held.items()}
        for g, body in enumerate(self._bodies):
            if body.finger is not None:
                opening = phase.openings.get(body.owner, 0.0)
                T = body.T_joint_body
                self._place(
                    g, body.joint, pin.SE3(T.rotation, T.translation + opening / 2 * body.finger)
                )
            elif body.kind == "part":
                number = int(body.owner)
                if number in holders:
                    arm = self.arm(holders[number])
                    joint, T_joint_flange = self.kinematics.frames[arm.flange]
                    T_tcp_part = phase.held[arm.name][1]
                    T_part_piece = self._T_part_piece[g]
                    T = T_joint_flange * arm.tool.T_flange_tcp * T_tcp_part * T_part_piece
                    self._place(g, joint, T)
                else:
                    self._place(g, 0, body.T_joint_body)
        self._activate(phase, holders)

    def _place(self, g: int, joint: int, T: pin.SE3) -> None:
        shape = self._geometry.geometryObjects[g]
        shape.parentJoint = joint
        shape.placement = T
        self._joint[g] = joint
        self._R[g] = T.rotation
        self._c[g] = T.translation + T.rotation @ self._centre[g]

    def _activate(self, phase: Phase, holders: dict[int, str]) -> None:
        moving = {self._arm_index[name] for name in phase.moving}
        carrier = self._carrier.copy()
        gone = np.zeros(len(self._bodies), bool)
        held = np.full(len(self._bodies), -1)
        target = np.zeros(len(self._bodies), bool)
        for g, number in self._part_bodies:
            if number in holders:
                carrier[g] = held[g] = self._arm_index[holders[number]]
            gone[g] = number in phase.absent
            target[g] = number == phase.target
        a, b = self._first, self._second
        arm_a, arm_b = carrier[a], carrier[b]
        moves = np.isin(arm_a, list(moving)) | np.isin(arm_b, list(moving))
        # A part in the hand touches the tool and the flange, and stays with them.
        in_hand = ((held[a] >= 0) & (held[a] == self._grip[b])) | (
            (held[b] >= 0) & (held[b] == self._grip[a])
        )
        one_piece = (held[a] >= 0) & (held[a] == held[b])
        self._active = moves & ~in_hand & ~one_piece & ~gone[a] & ~gone[b]
        self._margins = np.full(len(a), self.cell.policy.margin)
        self._margins[(arm_a == arm_b) & (arm_a >= 0)] = self.cell.policy.self_margin
        if phase.straight:
            tool = self._is_tool
            hand = (tool | (held >= 0)) & np.isin(carrier, list(moving))
            still = carrier < 0
            near = (hand[a] & still[b]) | (hand[b] & still[a])
            self._margins[near] = self.cell.policy.near_margin
            takes = (tool[a] & target[b]) | (tool[b] & target[a])
            self._margins[takes] = 0.0
        self._commons = self._common_joint(a, b)

    # -- questions -------------------------------------------------------------------------

    def configuration(self, q: Mapping[str, Floats]) -> Floats:
        """The whole configuration (nq,): named arms at `q` (n,), others at home."""
        return self.kinematics.configuration(q)

    def contact(self, q: Floats, d: Floats | None = None) -> Contact | None:
        """The first pair found that is, or may come, closer than its margin; None if all is clear.

        Args:
            q: whole configuration (nq,).
            d: how far each joint may move from it (nq,), or None for this state alone.
        """
        pairs, moves, lower = self._close(q, d, 0.0)
        for k, move, bound in zip(pairs, moves, lower, strict=True):
            needed = self._margins[k]
            if bound >= needed + move:
                continue
            distance = self._distance(k)
            if distance < needed + move:
                return self._contact_of(k, distance, move)
        return None

    def worst(
        self, q: Floats, d: Floats | None = None, reach: float = 0.05
    ) -> tuple[Contact | None, float]:
        """The pair with the least room, and how much it keeps beyond its need [m].

        Room is distance less margin less the motion bound; pairs further than `reach` beyond
        are not looked at, so None means at least that much room everywhere.
        """
        pairs, moves, lower = self._close(q, d, reach)
        best: Contact | None = None
        room = reach
        for k, move, bound in zip(pairs, moves, lower, strict=True):
            needed = self._margins[k] + move
            if bound - needed >= room:
                continue
            distance = self._distance(k)
            if distance - needed < room:
                room, best = distance - needed, self._contact_of(k, distance, move)
        return best, room

    def clearance(self, q: Floats, reach: float = 0.3) -> tuple[float, tuple[str, str] | None]:
        """The smallest distance of any active pair [m] up to `reach`, and which pair it is."""
        pairs, _, lower = self._close(q, None, reach)
        best, at = reach, None
        for k, bound in zip(pairs, lower, strict=True):
            if bound < best:
                distance = self._distance(k)
                if distance < best:
                    best, at = distance, self._labels(k)
        return best, at

    def allow_start_contacts(self, q: Floats, slack: float = 0.0005) -> None:
        """Let the part in the hand leave what it touches: it may not come nearer than at `q`.

        A part lies on the bin's floor and on other parts when it is taken.  For the pairs of
        held parts that are closer than their margin at `q`, the margin becomes the distance
        there, less `slack` [m] for the lean of the lift.
        """
        pairs, _, _ = self._close(q, None, 0.0)
        for k in pairs:
            if self._held_pair[k]:
                self._margins[k] = min(self._margins[k], self._distance(k) - slack)

    # -- machinery -------------------------------------------------------------------------

    def _close(self, q: Floats, d: Floats | None, extra: float) -> tuple[Floats, Floats, Floats]:
        self.checks += 1
        pin.updateGeometryPlacements(
            self.kinematics.model, self.kinematics.data, self._geometry, self._data, q
        )
        return close_pairs(
            self._parents,
            self._R0,
            self._p0,
            self._axes,
            self._slides,
            q,
            self._still if d is None else d,
            self._joint,
            self._R,
            self._c,
            self._half,
            self._radius,
            self._first,
            self._second,
            self._active,
            self._margins,
            self._commons,
            extra,
        )

    def _distance(self, k: int) -> float:
        return float(pin.computeDistance(self._geometry, self._data, int(k)).min_distance)

    def _labels(self, k: int) -> tuple[str, str]:
        return (self._bodies[self._first[k]].label, self._bodies[self._second[k]].label)

    def _contact_of(self, k: int, distance: float, move: float) -> Contact:
        return Contact(self._labels(k), distance, float(self._margins[k]), float(move))

    def _make_geometry(self) -> None:
        self._geometry = pin.GeometryModel()
        self._T_part_piece: dict[int, pin.SE3] = {}
        extents = []
        for g, body in enumerate(self._bodies):
            self._geometry.addGeometryObject(
                pin.GeometryObject(f"{g}", body.joint, body.T_joint_body, coal_shape(body.shape))
            )
            extents.append(extent(body.shape))
            if body.kind == "part":
                T_world_part = self.detections[int(body.owner)].T_world_part
                self._T_part_piece[g] = T_world_part.actInv(body.T_joint_body)
        self._centre = np.array([centre for centre, _, _ in extents])
        self._half = np.array([half for _, half, _ in extents])
        self._radius = np.array([radius for _, _, radius in extents])
        self._joint = np.array([body.joint for body in self._bodies])
        self._R = np.array([body.T_joint_body.rotation for body in self._bodies])
        self._c = np.array(
            [
                body.T_joint_body.act(centre)
                for body, centre in zip(self._bodies, self._centre, strict=True)
            ]
        )
        self._carrier = np.array([body.arm for body in self._bodies])
        self._is_tool = np.array([body.kind == "tool" for body in self._bodies])
        flanges = {arm.flange: index for index, arm in enumerate(self.cell.arms)}
        self._grip = np.array([_grip(body, flanges) for body in self._bodies])
        self._part_bodies = [
            (g, int(body.owner)) for g, body in enumerate(self._bodies) if body.kind == "part"
        ]

    def _make_tree(self) -> None:
        model = self.kinematics.model
        self._parents = np.array(list(model.parents))
        self._R0 = np.array([T.rotation for T in model.jointPlacements])
        self._p0 = np.array([T.translation for T in model.jointPlacements])
        self._axes = np.zeros((model.njoints, 3))
        self._slides = np.zeros(model.njoints)
        for joint in self.cell.robot.joints:
            if joint.kind != "fixed":
                number = model.getJointId(joint.name)
                self._axes[number] = joint.axis
                self._slides[number] = 1.0 if joint.kind == "prismatic" else 0.0
        self._still = np.zeros(model.nq)
        self._ancestors = np.zeros((model.njoints, model.njoints), bool)
        for j in range(1, model.njoints):
            self._ancestors[j] = self._ancestors[self._parents[j]]
            self._ancestors[j, j] = True

    def _make_pairs(self) -> None:
        pairs = pairs_of(self.cell, self.kinematics, self._bodies)
        self._first = np.array([a for a, _ in pairs])
        self._second = np.array([b for _, b in pairs])
        for a, b in pairs:
            self._geometry.addCollisionPair(pin.CollisionPair(a, b))
        self._data = pin.GeometryData(self._geometry)
        for request in self._data.distanceRequests:
            request.enable_nearest_points = False
        is_part = np.array([body.kind == "part" for body in self._bodies])
        self._held_pair = is_part[self._first] | is_part[self._second]

    def _common_joint(self, a: Floats, b: Floats) -> Floats:
        """The deepest joint that carries both bodies of each pair; 0 for none."""
        both = self._ancestors[self._joint[a]] & self._ancestors[self._joint[b]]
        numbers = np.arange(both.shape[1])
        return np.where(both, numbers, 0).max(axis=1)


def _grip(body: Body, flanges: Mapping[str, int]) -> int:
    """The arm whose hand this body is (tool or flange link), -1 when it is none."""
    if body.kind == "tool":
        return body.arm
    return flanges.get(body.owner, -1) if body.kind == "link" else -1
