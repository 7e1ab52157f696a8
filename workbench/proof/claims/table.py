"""Which two bodies are compared while something moves, and what distance they have to keep.

| pair | has to keep |
|---|---|
| two bodies that nothing that moves moves against each other | is not compared |
| links that the robot's description says need no check | is not compared |
| link or tool and another link or tool of the same arm | `self_margin` |
| held part and a link of the arm that holds it | `margin`, on approach and extract `near_margin` |
| tool or held part, on approach, extract, stir and lift, and what no arm carries | `near_margin` |
| tool and the part it takes, as it arrives | 0; a cup may press into it by `press` |
| the same, of a solid that the TCP does not name in `touches` | `near_margin` |
| closing or opening fingers and the part they take or let go | is not compared |
| lifted part and what it lies on, over the first `release` | as at the start, less 0.5 mm |
| the same, at every turn of a part whose roll is not known | see `grasps.rolls` |
| hand and the part it has let go of, until it has left it once | as at the start, less 0.5 mm |
| tool that stirs and the boxes that stand for all parts, on `stir` and `lift` | is not compared |
| the arm that stirs and the upper one of these, on that leg | is not compared |
| what a hand may hold and the bin or fixture that it leaves below it, on `lift` | is not compared |
| what a hand may hold and the tool that holds it | is not compared |
| what a hand may hold and a link of that arm, on `lift` | `near_margin` |
| the same on other legs, whatever the robot's description says | `margin` |
| tool or flange, straight at a slot, and the tool or fixture there | as there, less 0.5 mm |
| part that is assembled, on its last straight motion, and the one it comes onto | `clearance` |
| everything else | `margin` |

`least_distance_allowed` says what that is for bodies that do not touch at the start; it is
`near_margin` where there is more room.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from workbench.model.cell import Arm, Cell
from workbench.model.derived.assembling import insertion_of
from workbench.model.geometry import Bools, Floats, Ints
from workbench.model.tools.held_body import ball_label, held_labels, held_reach, stand_below
from workbench.proof.engine.bodies import CheckedBody, is_round
from workbench.proof.engine.pairs import BodyPairs, Pairs
from workbench.proof.engine.robot import Tree

NEARER_BY = 0.0005
"""[m] A lift that leans, and rounding, bring a part this much nearer to what it lies on."""

CONTENT = "bin_content"
"""What people call the box that stands for all parts while a hand stirs them."""

ABOVE_CONTENT = "above_bin_content"
"""What people call the box above that, in which a part may come to stand upright."""

TOUCH = 1e-6
"""[m] Apparent distance of touching bodies, by rounding."""

DEEPEST_IN_SLOT = 0.0005
"""[m] Tool and flange may be this deep in what they touch in a slot."""


def least_distance_allowed(begins: float) -> float:
    """The distance [m] that two bodies keep which begin a leg at a distance [m].

    Bodies that touch at the start may approach by `NEARER_BY`.  Separated bodies may approach by
    `NEARER_BY` or half their distance, whichever is less.
    """
    return begins - NEARER_BY if begins <= TOUCH else max(begins - NEARER_BY, begins / 2)


@dataclass(frozen=True, slots=True)
class Situation:
    """What is true during a stage of a leg.

    `moves` (nq,): which values of the configuration change.  `held`: detection -> name of the arm
    that holds it; `placed`: detection -> arm that has put it where it lies.  `near_arm`: the arm
    on approach or extract, empty for none.  `target`: the detection that its tool is about to
    take.  `fingers_move_at`: the detection around which fingers close or open now; contacts with
    it are not compared then.  `placed_now`: the detection that is on its last straight motion to
    its place.  `stirs`: the arm whose tool may be among the parts.  `slot`: the fixtures that tool
    and flange may touch on the linear legs at the slot of a tool.
    """

    moves: Bools
    held: Mapping[int, str] = field(default_factory=dict[int, str])
    placed: Mapping[int, str] = field(default_factory=dict[int, str])
    near_arm: str = ""
    target: int = -1
    fingers_move_at: int = -1
    placed_now: int = -1
    stirs: str = ""
    slot: frozenset[str] = frozenset()


class PairTable(BodyPairs):
    """All pairs of bodies that can ever be compared, and which of them count in a situation."""

    def __init__(self, cell: Cell, tree: Tree, bodies: tuple[CheckedBody, ...]) -> None:
        self._cell, self._tree, self._bodies = cell, tree, bodies
        names = {name: k for k, name in enumerate(dict.fromkeys(b.name for b in bodies))}
        name = np.array([names[b.name] for b in bodies])
        meet = ~np.eye(len(names), dtype=bool)
        for pair in cell.robot.disabled_pairs:
            first, second = (
                [k for k in map(names.get, _parse_name(n)) if k is not None] for n in pair
            )
            for i, j in product(first, second):
                meet[i, j] = meet[j, i] = False
        if (carrier := cell.scanner.on_arm) is not None and carrier.housing:
            # A scanner is screwed to the flange, which may be round and so turn against it.
            housing = names[f"link {carrier.arm}_scanner"]
            for link in cell.robot.rigid_with(carrier.flange):
                if (flange := names.get(f"link {link}")) is not None:
                    meet[housing, flange] = meet[flange, housing] = False
        self.counts = np.triu(meet[np.ix_(name, name)], 1)
        self.first, self.second = np.nonzero(self.counts)
        self._part = np.array([b.part for b in bodies])
        self._tool = np.array([b.kind == "tool" for b in bodies])
        self._content = np.array([b.label == CONTENT for b in bodies])
        self._above = np.array([b.label == ABOVE_CONTENT for b in bodies])
        self._unknown = np.isin([b.label for b in bodies], sorted(held_labels(cell)))
        balls = [ball_label(arm.name) for arm in cell.arms]
        self._ball = self._tool & np.isin([b.label for b in bodies], balls)
        barred = _barred_labels(cell)
        self._barred = np.array([b.label in barred for b in bodies])
        self._finger = np.array([b.is_finger for b in bodies])
        self._arm_numbers = {arm.name: k for k, arm in enumerate(cell.arms)}
        self.rounds = np.array([is_round(body, tree) for body in bodies])
        self._carrier = np.array([self._arm_numbers.get(b.arm, -1) for b in bodies])
        # The ball, and the tool that it is fixed to.
        a, b = self.first, self.second
        hand = self._tool[a] & self._tool[b] & (self._carrier[a] == self._carrier[b])
        self._with_hand = hand & (self._ball[a] | self._ball[b])
        self._kind = np.array([b.of_kind for b in bodies])
        self._fixture = np.array([b.fixture for b in bodies])
        carry = {link for arm in cell.arms for link in cell.robot.rigid_with(arm.flange)}
        at_flange = np.array([b.kind == "link" and b.label in carry for b in bodies])
        self._couples = self._tool | at_flange

    def pairs(self, now: Situation, joints: Ints) -> Pairs:
        """The pairs of a situation, in which these joints (b,), by index, carry the bodies."""
        policy = self._cell.policy
        carrier, holder = self._carrier.copy(), np.full(len(self._carrier), -1)
        for number, arm in now.held.items():
            holder[self._part == number] = self._arm_numbers[arm]
        carrier = np.where(holder >= 0, holder, carrier)
        placer = np.full(len(carrier), -1)
        for number, arm in now.placed.items():
            placer[self._part == number] = self._arm_numbers[arm]
        a, b = self.first, self.second
        above = self._tree.ancestors[:, now.moves].astype(float)
        # What moves a body with its joint; after these, what moves one that is round about that.
        moved = np.vstack([above, self._tree.ancestors[self._tree.before][:, now.moves]])
        against = moved @ (1.0 - above).T > 0.0
        # What is in the ball turns with the hand, although the ball looks the same.
        of = joints + len(above) * (self.rounds & ~self._ball)
        counts = against[of[a], joints[b]] | against[of[b], joints[a]]
        if now.fingers_move_at >= 0:
            part = self._part == now.fingers_move_at
            counts &= ~((part[a] & self._finger[b]) | (part[b] & self._finger[a]))
        if now.stirs:
            stirs = self._carrier == self._arm_numbers[now.stirs]
            for moves, box in ((stirs, self._above), (stirs & self._tool, self._content)):
                counts &= ~((moves[a] & box[b]) | (moves[b] & box[a]))
        rows = np.flatnonzero(counts & ~self._with_hand)
        a, b = a[rows], b[rows]
        commons = self._tree.commons[joints[a], joints[b]]

        is_held, in_hand, still = holder >= 0, (holder >= 0) | self._ball, carrier < 0
        own = (carrier[a] == carrier[b]) & (carrier[a] >= 0)
        margins = np.full(len(rows), policy.margin)
        margins[own & ~in_hand[a] & ~in_hand[b]] = policy.self_margin
        beds = np.zeros(len(rows), bool)
        if now.near_arm:
            number = self._arm_numbers[now.near_arm]
            works = (self._tool | is_held) & (carrier == number)
            near = (works[a] & still[b]) | (works[b] & still[a]) | (own & (in_hand[a] | in_hand[b]))
            margins[near] = policy.near_margin
            tool, target = self._tool & (carrier == number), self._part == now.target
            if now.target >= 0:
                lips = tool & ~self._barred
                arrives = (lips[a] & target[b]) | (lips[b] & target[a])
                margins[arrives] = -_press(self._cell.arm(now.near_arm))
            lifted = is_held & (holder == number)
            beds = (lifted[a] & still[b]) | (lifted[b] & still[a])
        released = (placer[a] >= 0) & (placer[a] == carrier[b])
        released |= (placer[b] >= 0) & (placer[b] == carrier[a])
        arms = np.stack([carrier[a], carrier[b]], axis=1)
        shown = ~own & ~beds
        if now.target >= 0:
            shown &= (self._part[a] != now.target) & (self._part[b] != now.target)
        if now.placed_now >= 0:
            mates, clearance = self._mates(now.placed_now)
            are_mates = mates[a, b] | mates[b, a]
            margins[are_mates] = clearance
            shown &= ~are_mates
        return Pairs(rows, margins, commons, beds, released, arms, shown, self._at_slot(now, a, b))

    def _at_slot(self, now: Situation, a: Ints, b: Ints) -> Bools:
        """Which pairs (p,) are of tool or flange of an arm and what they may touch at a slot."""
        in_slot = np.isin(self._fixture, sorted(now.slot))
        couples = self._couples & (self._carrier == self._arm_numbers.get(now.near_arm))
        return (in_slot[a] & couples[b]) | (in_slot[b] & couples[a])

    def never_met(self, pairs: Pairs, p: Floats) -> Bools:
        """Which pairs (p,) are of what a hand may hold and a solid it cannot meet on its way up.

        The TCP begins at a point (3,) [m] in the world; see `held_body.stand_below`.
        """
        solid = [body.is_solid for body in self._bodies]
        shapes = [(b.shape, b.T_joint_body) for b in self._bodies if b.is_solid]
        below = np.zeros(len(self._bodies), bool)
        below[solid] = stand_below(shapes, p, held_reach(self._cell), self._cell.bin.T_world_bin)
        a, b = self.first[pairs.rows], self.second[pairs.rows]
        return (self._unknown[a] & below[b]) | (self._unknown[b] & below[a])

    def _mates(self, number: int) -> tuple[Bools, float]:
        """Pairs of bodies (b, b) of a part and the one it comes onto, and what they keep [m]."""
        part = self._part == number
        kind = next((str(kind) for kind in self._kind[part]), "")
        insertion = insertion_of(self._cell, kind)
        if insertion is None:
            return np.zeros((len(part), len(part)), bool), 0.0
        base = (self._part < 0) & (self._kind == insertion.base)
        return part[:, None] & base, insertion.clearance

    def between_hands(self, pairs: Pairs, joints: Ints) -> Bools:
        """Which pairs (p,) are of two arms, True, except for two shoulders: these stay near.

        A shoulder is what the first two joints of an arm carry; `joints` (b,) carry the bodies now.
        """
        model = self._tree.model
        low = [model.getJointId(j) for arm in self._cell.arms for j in arm.joints[:2]]
        is_low = np.isin(joints, low)
        both_low = is_low[self.first[pairs.rows]] & is_low[self.second[pairs.rows]]
        first_arm, second_arm = pairs.arms.T
        return (first_arm >= 0) & (second_arm >= 0) & (first_arm != second_arm) & ~both_low

    def are_fingers(self, rows: Ints) -> Bools:
        """True (r,) where one of the two of a pair is a finger; `rows` (r,) are indices."""
        return self._finger[self.first[rows]] | self._finger[self.second[rows]]

    def is_rolled(self, row: int) -> bool:
        """Whether one of a pair is the room of all turns: how deep it is says nothing of the part.

        `grasps.rolls` asks that.
        """
        return any(self._bodies[int(k[row])].is_rolled for k in (self.first, self.second))

    def labels(self, row: int) -> tuple[str, str]:
        """What people call the two bodies of a pair."""
        first, second = int(self.first[row]), int(self.second[row])
        return self._bodies[first].label, self._bodies[second].label


def _parse_name(name: str) -> tuple[str, str]:
    """What may be called so in a list of pairs that need no check."""
    return f"link {name}", f"tool {name}"


def _barred_labels(cell: Cell) -> set[str]:
    """What people call the solids of tools that may not touch the part that the tool takes."""
    labels: set[str] = set()
    for arm in cell.arms:
        touches = {
            name for tcp in arm.tool.tcps if tcp.name == arm.tool.tcp for name in tcp.touches
        }
        solids = (*arm.tool.body, *(finger.solid for finger in arm.tool.fingers))
        labels |= {f"{arm.name} {s.name}" for s in solids if touches and s.name not in touches}
    return labels


def _press(arm: Arm) -> float:
    """[m] How deep a tool may be in the part it takes: a cup's lip gives way, fingers do not."""
    return 0.0 if arm.tool.fingers else arm.tool.press
