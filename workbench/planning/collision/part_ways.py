"""Straight extraction of a part from the bin: which directions are free, with any grasp.

The path of the part does not depend on the grasp.  If a neighbour on the part blocks it, no grasp
has to be tried.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations, product
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from workbench.model.candidate import Verdict
from workbench.model.cell import Cell
from workbench.model.geometry import Bools, Floats, Shape, frozen
from workbench.planning.collision.around import Around, first_contact
from workbench.planning.collision.bodies import extent, part_label
from workbench.planning.collision.distances.measuring import (
    Body,
    find_nearing,
    moved_distance,
)
from workbench.planning.collision.hands import NO_PAIR
from workbench.planning.collision.pairing import distances_to_keep
from workbench.planning.collision.surroundings import Surroundings
from workbench.planning.collision.unknown_rolls import Placed, place_pieces

CHECK_SPACING = 0.004
"""[m] Parts are checked this far apart on their way."""

ASIDE = 0.0005
"""[m] Deviation of an arm's motion from the straight line, between waypoints of its joints."""

WAY_START = 0.003
"""[m] So much of a way states whether it leads away from what the part lies against.

The distance of two convex bodies is a convex function of the way, so what gains here gains on."""

LEAN_ANGLES, LEAN_SIDES = np.deg2rad([8.0, 16.0, 24.0, 36.0, 48.0, 60.0]), 24
"""[rad] How far ways off lean, and to how many sides.  The least leads 1.4 mm away from a wall
within the first 10 mm, from which on `near_margin` is kept to it."""

MOST_OFF = 12
"""Reported extraction directions of a part, those that lead away most."""

COMES_OFF = 0.001
"""[m] Steps in which a part comes off what it lies on, where its turns are checked."""


PartLifts = tuple[Sequence[tuple[str, Floats]], Verdict | None]
"""Names of lifts with ways (3,) [m] on which a part meets nothing; or why there is none."""

Against = tuple[Body, Body, float]
"""A piece of a part, a body that it lies against, and how near [m] they are."""


@dataclass(frozen=True, slots=True)
class Caught:
    """Two bodies by their labels, of which the one is held back by the other, and how near [m].

    `is_sunk`: it lies too deep in that at every turn, so that its pose is wrong.
    """

    part: str
    bed: str
    distance: float
    is_sunk: bool


class _Pair(NamedTuple):
    """A piece of a part and a piece of what lies near, each at the turns that it may have.

    `begins` (t, u) [m] is how far they are apart, at the reach of the lift or beyond cut off.
    """

    piece: Placed
    bed: Placed
    label: str
    begins: Floats


class _Turns(NamedTuple):
    """A part and what lies near it, whose turns nobody knows.

    `possible` (t,) are the turns of the part at which it lies in nothing too deep; of those beds
    whose turn is known `deepest` is the one that it lies deepest in, by `depth` [m] or more.
    """

    pairs: list[_Pair]
    possible: Bools
    depth: float
    deepest: str


def steps_along(first: float, most: float) -> Floats:
    """How far [m] along a way something is checked, shape (k,): from `first` to its end."""
    return np.append(np.arange(first, most, CHECK_SPACING), most)


def kept_on_ways(cell: Cell) -> float:
    """The distance [m] that surely is too small for a linear motion, wherever the arm runs it."""
    return max(0.0, cell.policy.near_margin - ASIDE)


class PartWays:
    """The parts found, each by itself, and what stands around them; `known_lifts`: see `lifts`.

    Lifetime: as long as the surroundings.
    """

    def __init__(self, surroundings: Surroundings) -> None:
        self._cell, self._detections = surroundings.cell, surroundings.detections
        self._still = surroundings
        policy = surroundings.cell.policy
        self._sink, self._near, self._release = policy.sink, policy.near_margin, policy.release
        self._margin = kept_on_ways(surroundings.cell)
        self._reach = self._near + self._release + ASIDE
        self._around: dict[int, Around] = {}
        self._known: dict[tuple[int, bytes], tuple[str, float] | None] = {}
        self._caught: dict[tuple[int, bytes], Caught | None] = {}
        self._heaps: dict[float, list[int]] = {}
        self._turns: dict[int, _Turns | None] = {}
        self._against: dict[int, list[Against]] = {}
        self._first: dict[tuple[int, bytes], tuple[float, bool]] = {}
        self._off: dict[int, tuple[Floats, ...]] = {}
        self.known_lifts: dict[tuple[int, bytes, bytes], PartLifts] = {}

    def find_blocks(self, number: int, ways: Sequence[Floats]) -> list[tuple[str, float] | None]:
        """For each way (3,) [m] in the world: what a part meets on it and after how much [m].

        None where it meets nothing.  What counts is what comes nearer than `kept_on_ways`, once the
        part has come off what it lies on: the first `release` of the policy is left out.  Most
        grasps of a part have most ways in common, so what was found is remembered.

        Args:
            number: of the detection.
            ways: straight, from where it lies.
        """
        found: list[tuple[str, float] | None] = []
        for way in ways:
            key = (number, way.tobytes())
            if key not in self._known:
                self._known[key] = self._find_contact(number, way)
            found.append(self._known[key])
        return found

    def _find_contact(self, number: int, way: Floats) -> tuple[str, float] | None:
        around = self._of(number)
        if not around.cores.known.all():
            return None
        T, most = self._detections[number].T_world_part, float(np.linalg.norm(way))
        if most <= self._release:
            return None  # it is still coming off
        far = steps_along(self._release, most)
        places = T.translation + far[:, None] * way / most
        R = np.array(T.rotation, order="C")
        k, code = first_contact(R, places, 0.0, number, self._margin, around)
        return None if k < 0 else (self._label(code), float(far[k]))

    def gain(self, number: int, way: Floats) -> float:
        """How much [m] a part gets away from what it lies against in the first mm of its way.

        It is the least over all that is nearer at the start than the policy's `near_margin`: about
        0 where the part only rubs along something, negative where it is pushed into that, and at
        most `WAY_START`, as where nothing is near.  Parts of unknown roll count as in `room_of`.

        Args:
            number: of the detection.
            way: (3,) [m] in the world, straight, from where it lies.
        """
        return self._measure_begin(number, way)[0]

    def is_pushed(self, number: int, way: Floats) -> bool:
        """Whether a part comes nearer to something than `distances_to_keep` on its first mm.

        Args:
            number: of the detection.
            way: (3,) [m] in the world, as of `gain`.
        """
        return self._measure_begin(number, way)[1]

    def _measure_begin(self, number: int, way: Floats) -> tuple[float, bool]:
        """What a part gains [m] on the first mm of a way (3,) [m], and whether it is pushed."""
        key = (number, way.tobytes())
        if key not in self._first:
            if number not in self._against:
                self._against[number] = self._lying_against(number)
            most = float(np.linalg.norm(way))
            first = min(WAY_START, most)
            step = way * (first / most) if most > 0 else way
            against = self._against[number]
            begins = np.array([begin for _, _, begin in against])
            comes = np.array([moved_distance(a, b, step) for a, b, _ in against])
            gain = float(np.min(comes - begins, initial=first))
            self._first[key] = gain, bool((comes < distances_to_keep(begins)).any())
        return self._first[key]

    def ways_off(self, number: int) -> tuple[Floats, ...]:
        """The ways (3,) [m] in the world on which a part comes off and then meets nothing.

        They are searched for all over the half sphere above it, up to 60 degrees from upright, each
        as long as the policy's lift.
        Those come first that lead away most in their first mm, and of these the steepest.  It is
        the part alone that is checked, so all its grasps have them in common.

        Args:
            number: of the detection.
        """
        if number not in self._off:
            R, length = self._cell.bin.T_world_bin.rotation, self._cell.policy.lift_length
            ways: list[Floats] = list(length * _half_sphere() @ R.T) if length > 0 else []
            met = self.find_blocks(number, ways)
            free = [way for way, what in zip(ways, met, strict=True) if what is None]
            off = [way for way in free if not self.is_pushed(number, way)]
            # Gains that are equal but for rounding keep the order of the leans.
            off.sort(key=lambda way: -round(self.gain(number, way), 4))
            self._off[number] = tuple(off[:MOST_OFF])
        return self._off[number]

    def _lying_against(self, number: int) -> list[Against]:
        """Pieces of a part, what each is near to, and how near [m] they are."""
        T = self._detections[number].T_world_part
        pieces = self._still.pieces[number]
        reach = max(piece.reach for piece in pieces) + self._near
        found: list[Against] = []
        for body in self._still.bodies:
            bed = (body.shape, body.T_joint_body)
            if body.kind == "part" and int(body.owner) == number:
                continue
            if not _is_near(T.translation, reach, bed):
                continue
            for piece in pieces:
                placed_piece = (piece.shape, T * piece.T_owner_shape)
                begins = moved_distance(placed_piece, bed, np.zeros(3))
                if begins < self._near:
                    found.append((placed_piece, bed, begins))
        return found

    def standing_in(self, number: int, T_world_part: pin.SE3, margin: float) -> str | None:
        """What a part, put elsewhere, is nearer to than the margin [m]; None where nothing.

        Other parts found do not count: they may be gone by then.  Nor does what it comes onto in
        an assembly: how near these come is asked of the whole motion.
        """
        around = self._of(number)
        if not around.cores.known.all():
            return None
        counts = (around.owner < 0) & ~self._still.bases_of(number)
        fixed = around._replace(owner=np.where(counts, around.owner, number))
        R = np.array(T_world_part.rotation, order="C")
        p = np.array(T_world_part.translation)[None]
        _, code = first_contact(R, p, 0.0, number, margin, fixed)
        return None if code == NO_PAIR else self._label(code)

    def find_snag(self, number: int, way: Floats) -> Caught | None:
        """What may catch a part as it leaves its support, at some possible roll.

        For unknown rolls, of the part or of neighbours, every roll counts at which no overlap is
        deeper than the policy's `sink`.  If all rolls are known, the result is None: a later, more
        exact check covers that.

        Args:
            number: of the detection.
            way: (3,) [m] in the world; its first `release` is checked.
        """
        if all(detection.roll_known for detection in self._detections):
            return None
        key = (number, way.tobytes())
        if key not in self._caught:
            self._caught[key] = self._caught_on(number, way)
        return self._caught[key]

    def _caught_on(self, number: int, way: Floats) -> Caught | None:
        turns = self._turns_of(number)
        if turns is None:
            return None
        if not turns.possible.any():
            return Caught(part_label(number), turns.deepest, turns.depth, is_sunk=True)
        far = np.append(np.arange(COMES_OFF, self._release, COMES_OFF), self._release)
        steps = far[:, None] * way / float(np.linalg.norm(way))
        for pair in turns.pairs:
            matters = (pair.begins >= -self._sink) & (pair.begins < self._reach)
            if len(matters) > 1:
                matters &= turns.possible[:, None]
            for turn, other in np.argwhere(matters).tolist():
                begins = float(pair.begins[turn, other])
                keeps = min(self._near + ASIDE, begins - ASIDE)
                gap = find_nearing(pair.piece[turn], pair.bed[other], steps, begins, keeps)
                if gap is not None:
                    return Caught(part_label(number), pair.label, gap, is_sunk=False)
        return None

    def _turns_of(self, number: int) -> _Turns | None:
        """The turns of a part and of what lies near it; None where all of them are known."""
        if number not in self._turns:
            self._turns[number] = self._possible_turns(number)
        return self._turns[number]

    def _possible_turns(self, number: int) -> _Turns | None:
        detection, beds = self._detections[number], self._beds(number)
        if detection.roll_known and all(len(bed) == 1 for _, bed in beds):
            return None
        pieces, none = place_pieces(self._cell.part(detection.part), detection), np.zeros(3)
        # A turn is possible when its pieces are in nothing whose own place is known.
        possible, deepest = np.ones(max(len(piece) for piece in pieces), bool), (-np.inf, "")
        pairs: list[_Pair] = []
        for piece, (label, bed) in product(pieces, beds):
            begins = np.array(
                [
                    [moved_distance(body, other, none, self._reach) for other in bed]
                    for body in piece
                ]
            )
            pairs.append(_Pair(piece, bed, label, begins))
            if len(bed) == 1:
                possible &= begins[:, 0] >= -self._sink
                deepest = max(deepest, (float(-begins.max()), label))
        return _Turns(pairs, possible, *deepest)

    def _beds(self, number: int) -> list[tuple[str, Placed]]:
        """What lies near a part, piece by piece, with labels: parts as they may be turned."""
        found = [
            (body.label, ((body.shape, body.T_joint_body),))
            for body in self._still.bodies
            if body.kind != "part"
        ]
        for k, detection in enumerate(self._detections):
            if k != number:
                pieces = place_pieces(self._cell.part(detection.part), detection)
                found += [(part_label(k), piece) for piece in pieces]
        at = self._detections[number].T_world_part
        reach = max(solid.reach for solid in self._still.pieces[number])
        reach += self._release + 2 * self._near
        return [(label, bed) for label, bed in found if _is_near(at.translation, reach, bed[0])]

    def _of(self, number: int) -> Around:
        if number not in self._around:
            none = np.zeros(3)
            self._around[number] = self._still.around(
                [(solid.shape, solid.T_owner_shape, none) for solid in self._still.pieces[number]]
            )
        return self._around[number]

    def _label(self, code: int) -> str:
        return self._still.bodies[code % len(self._still.bodies)].label

    def gap(self, first: int, second: int) -> float:
        """How near two parts lie to each other [m], negative where they reach into each other."""
        mine, theirs = (
            [
                (solid.shape, self._detections[number].T_world_part * solid.T_owner_shape)
                for solid in self._still.pieces[number]
            ]
            for number in (first, second)
        )
        return min(moved_distance(a, b, np.zeros(3)) for a in mine for b in theirs)

    def heaps(self, gap: float) -> list[int]:
        """For each part the number of its heap: of one are parts nearer than `gap` [m].

        When a part is taken, others of its heap may move, also those that it does not touch itself.
        With 0 each is a heap of its own.
        """
        if gap in self._heaps:
            return self._heaps[gap]
        heap = list(range(len(self._detections)))
        if gap <= 0:
            return heap
        radius = {part.name: float(np.linalg.norm(part.mesh.points, axis=1).max())
                  for part in self._cell.parts}  # fmt: skip
        at = [(lying.T_world_part.translation, radius[lying.part]) for lying in self._detections]
        for first, second in combinations(range(len(heap)), 2):
            (p, p_radius), (q, q_radius) = at[first], at[second]
            is_far = float(np.linalg.norm(p - q)) - p_radius - q_radius >= gap
            if heap[first] != heap[second] and not is_far and self.gap(first, second) < gap:
                old, new = heap[second], heap[first]
                heap = [new if number == old else number for number in heap]
        self._heaps[gap] = heap
        return heap


@lru_cache(maxsize=1)
def _half_sphere() -> Floats:
    """Unit vectors (k, 3) upwards, the steepest first."""
    sides = np.arange(LEAN_SIDES) * 2 * np.pi / LEAN_SIDES
    lean, turn = np.meshgrid(LEAN_ANGLES, sides, indexing="ij")
    leaning = np.sin(lean) * np.cos(turn), np.sin(lean) * np.sin(turn), np.cos(lean)
    return frozen(np.vstack([(0.0, 0.0, 1.0), np.stack(leaning, axis=-1).reshape(-1, 3)]))


def _is_near(p: Floats, reach: float, body: tuple[Shape, pin.SE3]) -> bool:
    """Whether a body may be nearer than `reach` [m] to a place (3,) [m]."""
    shape, T = body
    centre, half, _ = extent(shape)
    offset = T.rotation.T @ (p - T.translation) - centre
    return float(np.linalg.norm(np.maximum(np.abs(offset) - half, 0.0))) < reach
