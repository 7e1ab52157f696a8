"""The world of one scan: one collision model whose attachments and margins change by phase."""

import math
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell, Policy
from workbench.model.geometry import Floats, Ints, Shape
from workbench.model.scan import Detection, Obstacle
from workbench.planning.collision import bodies
from workbench.planning.collision.bounds import close_pairs
from workbench.planning.collision.contact import Contact, Swept
from workbench.planning.collision.distances.cores import cores_of
from workbench.planning.collision.distances.measuring import distance, has_pieces
from workbench.planning.collision.pairing import DEEPEST_IN_SLOT, LegPhase, pairing_of
from workbench.planning.collision.part_ways import PartWays
from workbench.planning.collision.surroundings import Surroundings
from workbench.planning.collision.sweeping.edges import Edges, edges_of
from workbench.planning.collision.sweeping.look import Model
from workbench.planning.collision.sweeping.sweep import sweep_chain
from workbench.planning.collision.tool_check import ToolCheck
from workbench.planning.kinematics.chain import Chain, chain_of
from workbench.planning.kinematics.robot import Kinematics

LOOSENESS = 0.03
"""[m] By about this much the lower bound of a distance falls short; only a matter of speed."""

AT_REST = "at rest"
"""Where `World` has placed a part that no hand holds."""


class World:
    """The cell with the parts found, ready to answer "how close?" for any configuration.

    A whole configuration `q` (nq,) [rad, m] is in the order of `Kinematics`; pairs (k,) are indices
    into all pairs of bodies, those of the phase in `pairs`.  `deadline` [s], on the clock of
    `processor_time`, is when searches in it give up.  `surroundings` is what no arm carries.

    Lifetime: as long as cell and detections; `enter` changes what is attached, nothing is rebuilt.
    Concurrency: one thread at a time.
    """

    def __init__(
        self,
        cell: Cell,
        detections: tuple[Detection, ...],
        obstacles: tuple[Obstacle, ...] = (),
        policy: Policy | None = None,
        *,
        by_coal: bool = False,
    ) -> None:
        """The cell with those parts in it.

        Args:
            cell: as it is.
            detections: the parts found.
            obstacles: other objects in the scan.
            policy: where a request differs from the cell; corners are rounded as the cell says.
            by_coal: measure with Coal, as a proof does, not by our own search, which is faster.
        """
        self.cell = cell
        self.policy = replace(cell.policy if policy is None else policy, zone=cell.zone)
        self.motion = cell.controller.motion
        self.detections = detections
        self.obstacles = obstacles
        self.kinematics = Kinematics(cell)
        self.chains: dict[str, Chain] = {arm.name: chain_of(cell, arm) for arm in cell.arms}
        self.checks = 0
        self.deadline = math.inf
        self._by_coal = by_coal
        self.surroundings = Surroundings(cell, detections, obstacles)
        self._bodies = [*bodies.carried_bodies(cell, self.kinematics), *self.surroundings.bodies]
        self._geometry = bodies.geometry_of(self._bodies)
        self._T_part_piece = bodies.in_their_parts(self._bodies, detections)
        self._loose = [g for g, body in enumerate(self._bodies) if body.is_loose]
        self._centre = np.array([bodies.extent(body.shape)[0] for body in self._bodies])
        self._boxes = bodies.boxes_of(self._bodies)
        self._still = np.zeros(self.kinematics.model.nq)
        self._placed: dict[int, float | str | None] = {}
        self._make_pairs()
        self.enter(LegPhase(frozenset(arm.name for arm in cell.arms)))

    @cached_property
    def tool_check(self) -> ToolCheck:
        """The tools alone, without arms, among the same bodies."""
        return ToolCheck(self.surroundings, self.policy)

    @cached_property
    def part_ways(self) -> PartWays:
        """The parts alone, each by itself, among the same bodies."""
        return PartWays(self.surroundings)

    def arm(self, name: str) -> Arm:
        """The arm of that name."""
        return self.cell.arm(name)

    def enter(self, phase: LegPhase) -> None:
        """Attach, release and set margins for a leg."""
        holders = {number: arm for arm, (number, _) in phase.held.items()}
        lying = {
            number: self.chains[arm].pose(q) * T_tcp_part
            for arm, (number, T_tcp_part, q) in phase.placed.items()
        }
        for g in self._loose:
            body = self._bodies[g]
            if body.finger is not None:
                usual = 0.0 if body.owner in phase.moving else self.arm(body.owner).tool.stroke[1]
                opening = phase.openings.get(body.owner, usual)
                if self._placed.get(g) != opening:
                    T = body.T_joint_body.copy()
                    T.translation += opening / 2 * body.finger
                    self._place(g, body.joint, T)
                    self._placed[g] = opening
            elif int(body.owner) in holders:
                arm = self.arm(holders[int(body.owner)])
                joint, T_joint_flange = self.kinematics.frames[arm.flange]
                T_tcp_body = phase.held[arm.name][1] * self._T_part_piece[g]
                self._place(g, joint, T_joint_flange * arm.tool.T_flange_tcp * T_tcp_body)
                self._placed[g] = None
            elif int(body.owner) in lying:
                self._place(g, 0, lying[int(body.owner)] * self._T_part_piece[g])
                self._placed[g] = None
            elif self._placed.get(g) != AT_REST:
                self._place(g, 0, body.T_joint_body)
                self._placed[g] = AT_REST
        self.pairs = self._pairing.checks(phase, self._boxes.joint)
        self._use(self.pairs.margins)

    def _use(self, margins: Floats) -> None:
        self._margins = margins
        self._split = self._split_of(self.pairs.among)

    def _split_of(self, among: Ints) -> tuple[Ints, Ints]:
        """The pairs that compiled code can distinguish, and the others.

        Parts that may stay in touch are measured: how deep they are is not searched for there.
        """
        is_easy = (self._margins[among] >= 0.0) & self._is_easy[among]
        return among[is_easy], among[~is_easy]

    def _place(self, g: int, joint: int, T: pin.SE3) -> None:
        shape = self._geometry.geometryObjects[g]
        shape.parentJoint = joint
        shape.placement = T
        self._boxes.joint[g] = joint
        self._boxes.R[g] = T.rotation
        self._boxes.c[g] = T.translation + T.rotation @ self._centre[g]

    def configuration(self, q: Mapping[str, Floats]) -> Floats:
        """The whole configuration (nq,): named arms at `q` (n,), others at home."""
        return self.kinematics.configuration(q)

    def contact(self, q: Floats, among: Ints | None = None) -> Contact | None:
        """The first pair, of those `among` if given, closer than its margin at q (nq,)."""
        return self.look(q, self._still, among)[0]

    def contacts(self, q: Floats) -> tuple[Contact, ...]:
        """Every two bodies nearer than their margin at this whole configuration (nq,).

        Of several pairs with the same two labels the nearest stands; the nearest pair comes first.
        """
        pairs, _, _ = self._close(q, self._still, 0.0, None)
        found: dict[tuple[str, str], Contact] = {}
        for k in pairs.tolist():
            contact = self._contact_of(k, self._distance(k))
            known = found.get(contact.pair, contact)
            if contact.distance < contact.margin and contact.distance <= known.distance:
                found[contact.pair] = contact
        return tuple(sorted(found.values(), key=lambda contact: contact.distance))

    def meets(self, q: Floats) -> bool:
        """Whether different arms are too close to each other at this whole configuration (nq,)."""
        return self.look(q, self._still, self.pairs.between())[0] is not None

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

    def sweep(
        self, points: Floats, columns: Ints, base: Floats, resolution: float, among: Ints | None
    ) -> Swept:
        """Check a chain of curves as far as compiled code can.

        Args:
            points: control points (k, 3, n) of the curves, of the joints `columns`.
            columns: places of those joints in the whole configuration.
            base: whole configuration (nq,) of the others.
            resolution: [m] see `motion`.
            among: pairs to look at; None for all.
        """
        if self._by_coal:
            return Swept(len(points), None, self.pairs.among if among is None else among)
        easy, others = self._split if among is None else self._split_of(among)
        clear, pair, middle, looks = sweep_chain(
            points, columns, base, resolution, easy, self._margins, self.pairs.commons, self._model
        )
        self.checks += looks
        if pair < 0:
            return Swept(clear, None, others)
        q = base.copy()
        q[columns] = middle
        pin.updateGeometryPlacements(
            self.kinematics.model, self.kinematics.data, self._geometry, self._data, q
        )
        return Swept(clear, (self._contact_of(pair, self._distance(pair)), middle), others)

    def edges(
        self, columns: Ints, base: Floats, resolution: float, among: Ints | None = None
    ) -> Edges | None:
        """For compiled code to check motions in this phase, as `sweep`; None by Coal."""
        if self._by_coal:
            return None
        easy, others = self._split if among is None else self._split_of(among)
        commons, is_all = self.pairs.commons, len(others) == 0
        motion = self._model, columns, base, resolution, easy
        return edges_of(*motion, margins=self._margins, commons=commons, is_all=is_all)

    def count_parted(
        self, points: Floats, columns: Ints, base: Floats, resolution: float, among: Ints
    ) -> int:
        """How many curves at the end of a chain surely have no two bodies of `among` in touch.

        A part that is lifted leaves what it lies on, so that only the first curves have to be
        measured.  Arguments as those of `sweep`; 0 where compiled code cannot tell.
        """
        if self._by_coal or not self._is_easy[among].all():
            return 0
        backwards, margins = np.ascontiguousarray(points[::-1]), np.maximum(self._margins, 0.0)
        clear, _, _, looks = sweep_chain(
            backwards, columns, base, resolution, among, margins, self.pairs.commons, self._model
        )
        self.checks += looks
        return clear

    def worst(self, q: Floats, reach: float) -> tuple[Contact | None, float]:
        """The pair with the least room at `q` (nq,), and how much it has beyond its margin [m].

        Pairs with more room than `reach` [m] are not checked: None means at least that much.
        """
        pairs, _, lower = self._close(q, self._still, reach, None)
        best: Contact | None = None
        room = reach
        for k, bound in zip(pairs.tolist(), lower.tolist(), strict=True):
            needed = float(self._margins[k])
            if bound - needed < room:
                distance = self._distance(k)
                if distance - needed < room:
                    room, best = distance - needed, self._contact_of(k, distance)
        return best, room

    def clearance(
        self, q: Floats, reach: float, among: Ints | None = None
    ) -> tuple[float, tuple[str, str] | None]:
        """The smallest distance of any active pair [m] up to `reach`, and which pair it is.

        Links of one arm among themselves do not count: a wrist is always close to itself.
        """
        pairs, _, lower = self._close(q, self._still, reach, among)
        best, at, own = reach, None, self.pairs.own
        for k, bound in zip(pairs.tolist(), lower.tolist(), strict=True):
            if bound < best and not own[k]:
                distance = self._distance(k)
                if distance < best:
                    best, at = distance, self._labels(k)
        return best, at

    def nearest(self, q: Floats, among: Ints) -> Contact:
        """The pair of `among` with the least room at `q` (nq,)."""
        self._close(q, self._still, np.inf, among)
        distances = [self._distance(k) for k in among.tolist()]
        k = int(np.argmin(np.array(distances) - self._margins[among]))
        return self._contact_of(int(among[k]), distances[k])

    def allow_start_contacts(self, q: Floats, fixtures: Sequence[str] = ()) -> Contact | None:
        """Let parts that touch something where a leg begins, at `q` (nq,), come away from it.

        So may tool and flange from these `fixtures` of a slot.  See `Checks.at_start`.

        Returns:
            Where a part in the hand is deepest in what it lies on, if that is deeper than the
            policy's `sink`: its pose is wrong (of unknown rolls: `PartWays.find_snag`).  Or where
            tool or flange is deepest in its slot, if that is deeper than `DEEPEST_IN_SLOT`.
        """
        pairs, _, _ = self._close(q, self._still, 0.0, None)
        also = [k for name in fixtures for k in self.with_fixture(name) if self.pairs.couples[k]]
        pairs = pairs[self.pairs.may_begin_close[pairs] | np.isin(pairs, also)]
        at_slot = np.isin(pairs, also)
        distances = np.array([self._distance(k) for k in pairs.tolist()])
        self._use(self.pairs.at_start(pairs, distances, self.policy.near_margin))
        lies = (self.pairs.carriers[pairs] < 0).any(axis=1) & ~self._is_rolled[pairs]
        most = np.where(at_slot, DEEPEST_IN_SLOT, self.policy.sink)
        excess = np.where(at_slot | (self.pairs.lifts[pairs] & lies), -distances - most, -np.inf)
        if not len(pairs) or excess.max() <= 0.0:
            return None
        deepest = int(excess.argmax())
        return self._contact_of(int(pairs[deepest]), float(distances[deepest]))

    @contextmanager
    def at_full_margins(self, more: float = 0.0) -> Generator[None]:
        """Within it nothing of `allow_start_contacts` holds; margins are larger by `more` [m]."""
        allowed = self._margins
        self._use(self.pairs.margins + more if more else self.pairs.margins)
        try:
            yield
        finally:
            self._use(allowed)

    def place_shapes(self, q: Floats, pair: tuple[str, str]) -> tuple[tuple[Shape, pin.SE3], ...]:
        """The shapes of the bodies with these labels, with their poses in the world at `q` (nq,).

        A label may stand for several bodies; an unknown one for none.
        """
        pin.updateGeometryPlacements(
            self.kinematics.model, self.kinematics.data, self._geometry, self._data, q
        )
        return tuple(
            (body.shape, pin.SE3(self._data.oMg[g]))
            for g, body in enumerate(self._bodies)
            if body.label in pair
        )

    def with_fixture(self, name: str) -> Ints:
        """The pairs (k,) of the phase in which one body is of that fixture."""
        owned = np.array([(body.kind, body.owner) == ("fixture", name) for body in self._bodies])
        among, pairing = self.pairs.among, self._pairing
        return among[owned[pairing.first[among]] | owned[pairing.second[among]]]

    def _close(
        self, q: Floats, d: Floats, extra: float, among: Ints | None
    ) -> tuple[Ints, Floats, Floats]:
        """Pairs that may be closer than their margin and `extra`; see `close_pairs`.

        What `_distance` measures is at `q` after it.
        """
        self.checks += 1
        pairing, pairs = self._pairing, self.pairs
        close = close_pairs(
            self.kinematics.tree, self._boxes, q, d, pairing.first, pairing.second,
            pairs.among if among is None else among, self._margins, pairs.commons, extra,
        )  # fmt: skip
        if len(close[0]):
            pin.updateGeometryPlacements(
                self.kinematics.model, self.kinematics.data, self._geometry, self._data, q
            )
        return close

    def _distance(self, k: int) -> float:
        a, b = int(self._pairing.first[k]), int(self._pairing.second[k])
        first, second, T = self._bodies[a].shape, self._bodies[b].shape, self._data.oMg
        if has_pieces(first) or has_pieces(second):
            return distance(first, T[a], second, T[b])
        return float(pin.computeDistance(self._geometry, self._data, k).min_distance)

    def _labels(self, k: int) -> tuple[str, str]:
        first, second = self._pairing.first[k], self._pairing.second[k]
        return self._bodies[first].label, self._bodies[second].label

    def _contact_of(self, k: int, distance: float) -> Contact:
        return Contact(self._labels(k), distance, float(self._margins[k]))

    def _make_pairs(self) -> None:
        parts = tuple(detection.part for detection in self.detections)
        self._pairing = pairing_of(self.cell, self.policy, parts, self.kinematics, self._bodies)
        self._geometry.setCollisionPairs(self._pairing.meets, True)
        self._data = pin.GeometryData(self._geometry)
        cores = cores_of([body.shape for body in self._bodies], self._centre)
        first, second = self._pairing.first, self._pairing.second
        self._is_rolled = bodies.are_rolled(self._bodies, self.detections, first, second)
        self._is_easy = cores.known[first] & cores.known[second]
        self._model = Model(self.kinematics.tree, self._boxes, first, second, cores)
