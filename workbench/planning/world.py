"""The world of one scan: one collision model whose attachments and margins change by phase."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats, Ints
from workbench.model.scan import Detection
from workbench.planning.bodies import Body, bodies_of, coal_shape, extent, pairs_of
from workbench.planning.bounds import close_pairs
from workbench.planning.chain import Chain, chain_of
from workbench.planning.kinematics import Kinematics


LOOSENESS = 0.03
"""[m] By about this much the lower bound of a distance falls short; only a matter of speed."""


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
    """A pair that is too close: `distance` [m] (negative: penetration) is below `margin` [m]."""

    pair: tuple[str, str]
    distance: float
    margin: float


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
        self._among = np.flatnonzero(moves & ~in_hand & ~one_piece & ~gone[a] & ~gone[b])
        self._margins = np.full(len(a), self.cell.policy.margin)
        self._own = (arm_a == arm_b) & (arm_a >= 0)
        self._margins[self._own] = self.cell.policy.self_margin
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

    def contact(self, q: Floats) -> Contact | None:
        """The first pair found closer than its margin at this whole configuration (nq,)."""
        return self.look(q, self._still, None)[0]

    def look(self, q: Floats, d: Floats, among: Ints | None) -> tuple[Contact | None, Ints, float]:
        """What can be said about a motion from a look at its middle.

        Args:
            q: whole configuration (nq,) in the middle.
            d: how far each joint may move from it (nq,).
            among: pairs to look at, as a former look left them open; None for all.

        Returns:
            A contact at `q`, if there is one; otherwise the pairs that the motion might bring
            closer than their margins, and the largest motion bound of those [m].
        """
        pairs, moves, lower = self._close(q, d, 0.0, among)
        unclear: list[int] = []
        furthest = 0.0
        for k, move, bound in zip(pairs.tolist(), moves.tolist(), lower.tolist(), strict=True):
            needed = self._margins[k]
            # Certainly no contact now, and so long a way that measuring would hardly clear it.
            hopeless = bound >= needed and bound < needed + move - LOOSENESS
            if not hopeless:
                distance = self._distance(k)
                if distance < needed:
                    return self._contact_of(k, distance), pairs, move
                if distance >= needed + move:
                    continue
            unclear.append(k)
            furthest = max(furthest, move)
        return None, np.array(unclear, dtype=np.int64), furthest

    def worst(self, q: Floats, reach: float) -> tuple[Contact | None, float]:
        """The pair with the least room at `q` (nq,), and how much it has beyond its margin [m].

        Pairs with more room than `reach` [m] are not looked at: None means at least that much.
        """
        pairs, _, lower = self._close(q, self._still, reach, None)
        best: Contact | None = None
        room = reach
        for k, bound in zip(pairs.tolist(), lower.tolist(), strict=True):
            needed = self._margins[k]
            if bound - needed < room:
                distance = self._distance(k)
                if distance - needed < room:
                    room, best = distance - needed, self._contact_of(k, distance)
        return best, room

    def clearance(self, q: Floats, reach: float = 0.3) -> tuple[float, tuple[str, str] | None]:
        """The smallest distance of any active pair [m] up to `reach`, and which pair it is.

        Links of one arm among themselves do not count: a wrist is always close to itself.
        """
        pairs, _, lower = self._close(q, self._still, reach, None)
        best, at = reach, None
        for k, bound in zip(pairs.tolist(), lower.tolist(), strict=True):
            if bound < best and not self._own[k]:
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
        pairs, _, _ = self._close(q, self._still, 0.0, None)
        for k in pairs.tolist():
            if self._held_pair[k]:
                self._margins[k] = min(self._margins[k], self._distance(k) - slack)

    # -- machinery -------------------------------------------------------------------------

    def _close(
        self, q: Floats, d: Floats, extra: float, among: Ints | None
    ) -> tuple[Ints, Floats, Floats]:
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
            d,
            self._joint,
            self._R,
            self._c,
            self._half,
            self._radius,
            self._first,
            self._second,
            self._among if among is None else among,
            self._margins,
            self._commons,
            extra,
        )

    def _distance(self, k: int) -> float:
        return float(pin.computeDistance(self._geometry, self._data, k).min_distance)

    def _labels(self, k: int) -> tuple[str, str]:
        return (self._bodies[self._first[k]].label, self._bodies[self._second[k]].label)

    def _contact_of(self, k: int, distance: float) -> Contact:
        return Contact(self._labels(k), distance, float(self._margins[k]))

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
        meets = pairs_of(self.cell, self.kinematics, self._bodies)
        self._first, self._second = np.nonzero(meets)
        self._geometry.setCollisionPairs(meets, True)
        self._data = pin.GeometryData(self._geometry)
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
