"""Which pairs of bodies count in a phase, and what distance each must keep."""

import threading
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell, Policy
from workbench.model.derived.assembling import insertion_of
from workbench.model.derived.by_tcp import may_touch
from workbench.model.geometry import Bools, Floats, Ints
from workbench.model.tools.held_body import held_labels
from workbench.planning.collision.bodies import Body, is_ball, obstacle_label, pairs_of
from workbench.planning.kinematics.robot import Kinematics

NEARER_BY = 0.0005
"""[m] What is in touch where a lift begins may come nearer by this: the lift leans."""

DEEPEST_IN_SLOT = 0.0005
"""[m] Tool and flange may be this deep in what they touch in a slot."""

TOUCHING_WITHIN = 1e-6
"""[m] Bodies farther apart than this are not in touch; what touches exactly is rounded."""

MOST_PAIRINGS = 16
"""Kept for cells and numbers of parts that come again."""


def distances_to_keep(begins: Floats) -> Floats:
    """The distances [m] that are kept by what is this far apart (k,) [m] where a leg begins.

    What is in touch may come nearer by `NEARER_BY`.  What is clear stays so, by half at least: the
    rest is for what states are checked apart, and measured otherwise.
    """
    return np.where(
        begins > TOUCHING_WITHIN, np.maximum(begins / 2, begins - NEARER_BY), begins - NEARER_BY
    )


@dataclass(frozen=True, slots=True)
class LegPhase:
    """What is true during one leg.

    `moving`: the arms that move.  `openings`: arm -> finger opening [m]; of arms not named, fingers
    are closed as they move, and as far open as they can be where they stand: nobody knows how they
    were left.  `held`: arm -> (detection, `T_tcp_part`).  `placed`: arm -> (detection,
    `T_tcp_part`, configuration (n,) [rad] in which it has let go of it); there the part stays.
    `targets`: arm -> the part that its tool is about to take.  `straight`: arms whose tool and held
    part may come as near as the policy's `near_margin`.  `inserts`: arms on the last linear motion
    to a place, whose part may come as near to the one it is assembled onto as their clearance.
    `stirs`: arms that may be in the world's second obstacle, and their tools in the first, too: a
    box that stands for all parts, and one above it.  `below`: what a hand cannot meet with what it
    may hold, by the labels of bodies.
    """

    moving: frozenset[str]
    openings: Mapping[str, float] = field(default_factory=dict)
    held: Mapping[str, tuple[int, pin.SE3]] = field(default_factory=dict)
    placed: Mapping[str, tuple[int, pin.SE3, Floats]] = field(default_factory=dict)
    targets: Mapping[str, int] = field(default_factory=dict)
    straight: frozenset[str] = frozenset()
    inserts: frozenset[str] = frozenset()
    stirs: frozenset[str] = frozenset()
    below: frozenset[str] = frozenset()

    @property
    def key(self) -> tuple[object, ...]:
        """What the pairs depend on: all but the numbers of the poses."""
        holders = tuple(sorted((arm, number) for arm, (number, _) in self.held.items()))
        placers = tuple(sorted((arm, number) for arm, (number, _, _) in self.placed.items()))
        targets = tuple(sorted(self.targets.items()))
        among = self.straight, self.inserts, self.stirs, self.below
        return (self.moving, holders, placers, targets, *among)


@dataclass(frozen=True, slots=True, eq=False)
class Checks:
    """The pairs of a phase; arrays have an entry for each pair.

    Attributes:
        arms: indices of the arms by name.
        among: indices of the pairs to check.
        margins: margins (pairs,) [m].
        carriers: indices of the arms that carry the bodies (pairs, 2); -1: none.
        commons: the deepest joint that carries both bodies (pairs,).
        lifts: whether a body is a part that is being lifted.
        leaves: whether a body is a placed part, and the other is of the arm that now leaves it.
        placed: whether a body is a placed part.
        couples: whether a body is of a tool, or of a link that is rigid with a flange.
    """

    arms: Mapping[str, int]
    among: Ints
    margins: Floats
    carriers: Ints
    commons: Ints
    lifts: Bools
    leaves: Bools
    placed: Bools
    couples: Bools

    @property
    def own(self) -> Bools:
        """Whether both bodies are of one arm."""
        return (self.carriers[:, 0] == self.carriers[:, 1]) & (self.carriers[:, 0] >= 0)

    @property
    def may_begin_close(self) -> Bools:
        """Pairs that may be closer than their margin where a leg begins; none of two arms."""
        first, second = self.carriers.T
        return (self.lifts | self.leaves) & ((first < 0) | (second < 0) | (first == second))

    def at_start(self, pairs: Ints, distances: Floats, near: float) -> Floats:
        """The margins [m] of a leg at whose start the pairs have these `distances` [m].

        A part touches the bin's floor and other parts when it is grasped.  During the lift it keeps
        `distances_to_keep` to them.  A hand that leaves a released part keeps `near` [m] to it, and
        does not come nearer where it is closer already; see `picking.leaving`.
        """
        # The margins of the phase serve others too; these are for this leg alone.
        margins = np.where(self.leaves, np.minimum(self.margins, near), self.margins)
        margins[pairs] = np.minimum(margins[pairs], distances_to_keep(distances))
        return margins

    def alone(self, arm: str) -> Ints:
        """The pairs that one arm has with itself and with what no arm carries."""
        is_own = self.carriers[self.among] == self.arms[arm]
        is_still = self.carriers[self.among] < 0
        return self.among[is_own.any(axis=1) & (is_own | is_still).all(axis=1)]

    def involving(self, arm: str) -> Ints:
        """The pairs of which one body at least is carried by an arm."""
        return self._of(arm, self.among)

    def _of(self, arm: str, among: Ints) -> Ints:
        return among[(self.carriers[among] == self.arms[arm]).any(axis=1)]

    def all_but(self, arm: str, other: str) -> Ints:
        """The pairs of one arm, except for those with the other."""
        return np.setdiff1d(self.involving(arm), self.between(arm, other))

    def to_placed(self, arm: str) -> Ints:
        """The pairs of an arm with parts that other arms have placed."""
        among = self.among[self.placed[self.among]]
        return self._of(arm, among[~self.leaves[among]])

    def left_behind(self, arm: str) -> Ints:
        """The pairs of an arm with the part that it has just let go of."""
        return self._of(arm, self.among[self.leaves[self.among]])

    def between(self, *arms: str) -> Ints:
        """The pairs of bodies that different arms carry, of these arms if any are named."""
        counts = np.zeros(len(self.arms) + 1, bool)  # the last one is of what no arm carries
        counts[[self.arms[arm] for arm in arms or self.arms]] = True
        first, second = self.carriers[self.among].T
        return self.among[counts[first] & counts[second] & (first != second)]


class Pairing:
    """The rules by which pairs count, worked out once for each kind of phase.

    Where the parts lie changes nothing in them, so worlds share it: see `pairing_of`.
    """

    def __init__(
        self,
        cell: Cell,
        policy: Policy,
        parts: tuple[str, ...],
        kinematics: Kinematics,
        bodies: list[Body],
    ) -> None:
        self._insertions = tuple(insertion_of(cell, part) for part in parts)
        self._assembled = np.array([b.owner if b.kind == "assembled" else "" for b in bodies])
        self.meets = pairs_of(cell, bodies)
        # One after the other in memory: compiled code is made once for arrays that lie like that.
        self.first, self.second = (k.copy() for k in np.nonzero(self.meets))
        self._policy = policy
        self._arm = {arm.name: index for index, arm in enumerate(cell.arms)}
        flanges = {arm.flange: index for index, arm in enumerate(cell.arms)}
        self._carrier = np.array([body.arm for body in bodies])
        self._press = {arm.name: 0.0 if arm.tool.fingers else arm.tool.press for arm in cell.arms}
        self._tool = np.array([body.kind == "tool" for body in bodies])
        touching = {
            f"{arm.name} {solid.name}"
            for arm in cell.arms
            for solid in (*arm.tool.body, *(finger.solid for finger in arm.tool.fingers))
            if may_touch(arm.tool, solid.name)
        }
        self._lip = self._tool & np.array([body.label in touching for body in bodies])
        unknown = held_labels(cell)
        self._unknown = np.array([body.label in unknown for body in bodies])
        self._labels = np.array([body.label for body in bodies])
        self._boxes = [np.array([b.label == obstacle_label(k) for b in bodies]) for k in (0, 1)]
        self._part = np.array([int(b.owner) if b.kind == "part" else -1 for b in bodies])
        self._hand = np.array(
            [body.arm if body.kind == "tool" else flanges.get(body.owner, -1) for body in bodies]
        )
        carry = {link for arm in cell.arms for link in cell.robot.rigid_with(arm.flange)}
        at_flange = np.array([body.kind == "link" and body.owner in carry for body in bodies])
        couples, scanner = self._tool | at_flange, cell.scanner.on_arm
        fixed = couples | np.array(
            [scanner is not None and b.owner == scanner.label for b in bodies]
        )
        self._couples = couples[self.first] | couples[self.second]
        # What the hand may hold is fixed to these, even where a round flange hangs elsewhere.
        ball = np.array([is_ball(body) for body in bodies])
        self._balls = ball[self.first] | ball[self.second]
        self._with_ball = (ball[self.first] & fixed[self.second]) | (
            ball[self.second] & fixed[self.first]
        )
        parents = list(kinematics.model.parents)
        self._ancestors = np.zeros((len(parents), len(parents)), bool)
        for j in range(1, len(parents)):
            self._ancestors[j] = self._ancestors[parents[j]]
            self._ancestors[j, j] = True
        self._known: dict[tuple[object, ...], Checks] = {}

    def checks(self, phase: LegPhase, joint: Ints) -> Checks:
        """The pairs of a phase.

        Args:
            phase: what is true.
            joint: which joint carries each body in it (b,).
        """
        if phase.key not in self._known:
            self._known[phase.key] = self._checks(phase, joint)
        return self._known[phase.key]

    def _checks(self, phase: LegPhase, joint: Ints) -> Checks:
        a, b = self.first, self.second
        moving = [self._arm[name] for name in phase.moving]
        held = np.full(len(self._carrier), -1)
        for name, (number, _) in phase.held.items():
            held[self._part == number] = self._arm[name]
        carrier = np.where(held >= 0, held, self._carrier)
        moves = np.isin(carrier, moving)
        # A part in the hand touches the tool and the flange, and stays with them.
        in_hand = ((held[a] >= 0) & (held[a] == self._hand[b])) | (
            (held[b] >= 0) & (held[b] == self._hand[a])
        )
        one_piece = (held[a] >= 0) & (held[a] == held[b])
        counts = (moves[a] | moves[b]) & ~in_hand & ~one_piece
        stirs = np.isin(carrier, [self._arm[name] for name in phase.stirs])
        for moved, box in zip((stirs & self._tool, stirs), self._boxes, strict=True):
            counts &= ~((moved[a] & box[b]) | (moved[b] & box[a]))
        own = (carrier[a] == carrier[b]) & (carrier[a] >= 0)
        counts &= ~(self._with_ball & own)
        if phase.below:
            below = np.isin(self._labels, sorted(phase.below))
            counts &= ~((self._unknown[a] & below[b]) | (self._unknown[b] & below[a]))
        margins = np.full(len(a), self._policy.margin)
        margins[own & ~self._balls] = self._policy.self_margin
        if phase.straight:
            straight = np.isin(carrier, [self._arm[name] for name in phase.straight])
            works = (self._tool | (held >= 0)) & straight
            still = carrier < 0
            near = (works[a] & still[b]) | (works[b] & still[a]) | (own & self._balls)
            margins[near] = self._policy.near_margin
            for name, number in phase.targets.items():
                tool = self._lip & (self._carrier == self._arm[name])
                target = self._part == number
                margins[(tool[a] & target[b]) | (tool[b] & target[a])] = -self._press[name]
        for name in phase.inserts & phase.held.keys():
            number, _ = phase.held[name]
            if (insertion := self._insertions[number]) is not None:
                part, base = self._part == number, self._assembled == insertion.base
                margins[(part[a] & base[b]) | (part[b] & base[a])] = insertion.clearance
        both = self._ancestors[joint[a]] & self._ancestors[joint[b]]
        commons = np.where(both, np.arange(both.shape[1]), 0).max(axis=1)
        carriers = np.stack([carrier[a], carrier[b]], axis=1)
        lifted = (held >= 0) & np.isin(held, [self._arm[name] for name in phase.straight])
        # Who has placed each body, -1 for all but parts that lie where an arm has put them.
        placer = np.full(len(self._carrier), -1)
        for name, (number, _, _) in phase.placed.items():
            placer[self._part == number] = self._arm[name]
        is_left = np.isin(placer, moving)
        leaves = (is_left[a] & (carrier[b] == placer[a])) | (is_left[b] & (carrier[a] == placer[b]))
        return Checks(
            self._arm,
            np.flatnonzero(counts),
            margins,
            carriers,
            commons,
            lifted[a] | lifted[b],
            leaves,
            (placer[a] >= 0) | (placer[b] >= 0),
            self._couples,
        )


_PAIRINGS: dict[tuple[object, ...], Pairing] = {}
_CHANGES = threading.Lock()


def pairing_of(
    cell: Cell, policy: Policy, parts: tuple[str, ...], kinematics: Kinematics, bodies: list[Body]
) -> Pairing:
    """The pairing of all worlds of this cell with found parts of these names, in this order.

    Worlds with as many bodies, and the same ones assembled, differ in nothing that counts here.

    Concurrency: any thread; several of them make worlds for the page.
    """
    assembled = tuple(body.owner for body in bodies if body.kind == "assembled")
    tcps = tuple(arm.tool.tcp for arm in cell.arms)
    key = (cell.digest, tcps, policy, parts, len(bodies), assembled)
    with _CHANGES:
        if key not in _PAIRINGS:
            while len(_PAIRINGS) >= MOST_PAIRINGS:
                del _PAIRINGS[next(iter(_PAIRINGS))]
            _PAIRINGS[key] = Pairing(cell, policy, parts, kinematics, bodies)
        return _PAIRINGS[key]
