"""Compiled: which pairs of bodies are distinguished without measuring them."""

from typing import NamedTuple

import numpy as np
from numba import njit

from workbench.model.geometry import Bools, Floats, Ints
from workbench.proof.engine.boxes import gap
from workbench.proof.engine.compiled import njit_in_place
from workbench.proof.engine.frames import (
    FIRST,
    Bodies,
    BodyPoses,
    JointTree,
    SetExtents,
    bound_motion,
)
from workbench.proof.engine.plane import ROUNDING, apart

MOST_GAINED = 0.3
"""[m] Planes hardly ever give a bound that is better by more than this, and take longest of all;
only a matter of speed."""


class PairQuery(NamedTuple):
    """Pairs (p,) of bodies `first` and `second`, and what is asked of them.

    `commons` is the joint next to both that moves both, `margins` [m] what they have to keep;
    `shown`: how near they come is reported, too.
    """

    first: Ints
    second: Ints
    commons: Ints
    margins: Floats
    shown: Bools


class OpenPairs(NamedTuple):
    """Pairs whose lower bound is not yet large enough: `items` (n, 3) as `Batch` says.

    `lower` [m] is a bound in the middles of the sets; `moves` [m] how much nearer they may come in
    them, `whole_bounds` [m] a bound for the whole of them.
    """

    items: Ints
    lower: Floats
    moves: Floats
    whole_bounds: Floats


@njit(cache=True)
def select_pairs_in_sight(
    asked: PairQuery, sight: float, sides: Ints, split: int, bodies: Bodies, world: BodyPoses
) -> Ints:  # pragma: no cover (compiled)
    """The pairs in sets (n, 3), without those whose swept boxes stay out of sight of each other.

    Around all that a body passes in all sets there is a box along the axes of the world.  What is
    no number is not far apart: such pairs are checked.

    Args:
        asked: the pairs.
        sight: [m] up to here distances are reported.
        sides: (b,) 1 where a second arm carries a body.
        split: this many sets are the first arm's, all others the second's.
        bodies: all bodies.
        world: where those of the pairs are at the middles of the sets.
    """
    count = len(world.moves)
    low, high = np.full((len(bodies.joints), 3), np.inf), np.full((len(bodies.joints), 3), -np.inf)
    needed = np.zeros(len(bodies.joints), np.bool_)
    for pair in range(len(asked.first)):
        needed[asked.first[pair]] = needed[asked.second[pair]] = True
    for b in np.flatnonzero(needed):
        for k in range(split if sides[b] else 0, count if sides[b] else split):
            far = world.moves[k, b] + bodies.radii[b]
            for i in range(3):
                # These pass on what is no number; `min` and `max` may lose it.
                low[b, i] = np.minimum(low[b, i], world.centres[k, b, i] - far)
                high[b, i] = np.maximum(high[b, i], world.centres[k, b, i] + far)
    chosen, found = np.empty(len(asked.first), np.int64), 0
    for pair in range(len(asked.first)):
        a, b, square = asked.first[pair], asked.second[pair], 0.0
        for i in range(3):
            off = np.maximum(np.maximum(low[a, i] - high[b, i], low[b, i] - high[a, i]), 0.0)
            square += off * off
        need = asked.margins[pair]
        if asked.shown[pair]:
            need = np.maximum(need, sight)
        # Boxes that overlap say nothing of bodies, which may be in each other as deep as `need`.
        if not (square > 0.0 and np.sqrt(square) - ROUNDING >= need):
            chosen[found] = pair
            found += 1
    others = max(count - split, 1)
    items, n = np.empty((split * others * found, 3), np.int64), 0
    for index in range(split):
        for other in range(others):
            for pair in chosen[:found]:
                second = index if count == split else split + other
                items[n, 0] = second if sides[asked.first[pair]] else index
                items[n, 1] = second if sides[asked.second[pair]] else index
                items[n, 2] = pair
                n += 1
    return items


@njit(cache=True)
def select_nearest_pairs(
    items: Ints, asked: PairQuery, at: Ints, waypoints: int, bodies: Bodies, world: BodyPoses
) -> Ints:  # pragma: no cover (compiled)
    """The pair that seems nearest after each waypoint (n,), of those shown, by index.

    Args:
        items: (n, 3) in which two of the sets, and which of the pairs, see `Batch`.
        asked: the pairs.
        at: (k,) the waypoint before each set, see `Batch`.
        waypoints: how many there are.
        bodies: all bodies.
        world: where those of the pairs are at the middles of the sets.
    """
    lowest, best = np.full(waypoints, np.inf), np.full(waypoints, -1)
    axis, scratch = np.empty(3), np.empty((4, 3))
    for n in range(len(items)):
        ka, kb, pair = int(items[n, 0]), int(items[n, 1]), int(items[n, 2])
        a, b, place = int(asked.first[pair]), int(asked.second[pair]), max(at[ka], at[kb])
        if not asked.shown[pair]:
            continue
        square = 0.0
        for i in range(3):
            off = world.centres[ka, a, i] - world.centres[kb, b, i]
            square += off * off
        low = np.sqrt(square) - bodies.radii[a] - bodies.radii[b]
        if low < lowest[place]:
            low = max(low, gap(ka, a, kb, b, bodies, world, float(lowest[place]), axis, scratch))
            if low < lowest[place]:
                lowest[place], best[place] = low, n
    return best[best >= 0]


@njit(cache=True)
def sieve(
    items: Ints,
    asked: PairQuery,
    goals: Floats,
    at: Ints,
    bounds: Floats,
    normals: Floats,
    chain: JointTree,
    bodies: Bodies,
    world: BodyPoses,
    spread: SetExtents,
) -> OpenPairs:  # pragma: no cover (compiled)
    """The pairs whose lower bound is not large enough without measuring them.

    Args:
        items: (n, 3) in which two of the sets, and which of the pairs, see `Batch`.
        asked: the pairs.
        goals: (w,) [m] how far apart is far enough after each waypoint, where that is shown.
        at: (k,) the waypoint before each set, see `Batch`.
        bounds: (w,) [m] after each waypoint; lowered to those of pairs that are distinguished.
        normals: (b, b, 2, 3) directions from the one to the other that were good before, as the
            one and as the other sees them; zero where none is known.
        chain: the joints.
        bodies: all bodies.
        world: where those of the pairs are at the middles of the sets.
        spread: the sets.
    """
    lower, moves, whole_bounds = np.empty(len(items)), np.empty(len(items)), np.empty(len(items))
    left, normal, scratch = np.empty(len(items), np.int64), np.empty(3), np.empty((4, 3))
    count = _sift(
        items, asked, goals, at, bounds, normals, chain, bodies, world, spread, left,
        lower, moves, whole_bounds, normal, scratch,
    )  # fmt: skip
    return OpenPairs(items[left[:count]], lower[:count], moves[:count], whole_bounds[:count])


@njit_in_place
def _sift(
    items: Ints,
    asked: PairQuery,
    goals: Floats,
    at: Ints,
    bounds: Floats,
    normals: Floats,
    chain: JointTree,
    bodies: Bodies,
    world: BodyPoses,
    spread: SetExtents,
    left: Ints,
    lower: Floats,
    moves: Floats,
    whole_bounds: Floats,
    normal: Floats,
    scratch: Floats,
) -> int:  # pragma: no cover (compiled)
    """Write what `sieve` returns into `left` and the next three (n,); how many pairs that is.

    `left` are numbers of items; `normal` (3,) and `scratch` (4, 3) are those of `gap`.
    """
    count, most = 0, world.moves
    for n in range(len(items)):
        ka, kb, pair = int(items[n, 0]), int(items[n, 1]), int(items[n, 2])
        a, b = int(asked.first[pair]), int(asked.second[pair])
        common, need = int(asked.commons[pair]), float(asked.margins[pair])
        place = max(at[ka], at[kb])
        if asked.shown[pair]:
            need = max(need, float(goals[place]))
        square = 0.0
        for i in range(3):
            off = world.centres[ka, a, i] - world.centres[kb, b, i]
            square += off * off
        low, far = (
            np.sqrt(square) - bodies.radii[a] - bodies.radii[b] - ROUNDING,
            most[ka, a] + most[kb, b],
        )
        bound, is_near = low - far, True
        if bound < need:
            off = max(_off(ka, a, kb, b, bodies, world), _off(kb, b, ka, a, bodies, world))
            low = max(low, off - ROUNDING)
            bound = low - far
        if bound < need:
            if common != 0:
                far = bound_motion(ka, a, common, chain, bodies, world, spread.spans)
                far += bound_motion(kb, b, common, chain, bodies, world, spread.spans)
            wide = gap(ka, a, kb, b, bodies, world, need + far, normal, scratch)
            low = max(low, wide - ROUNDING)
            bound = low - far
            if bound < need and low > 0.0 and not _is_known(normals, a, b, FIRST):
                _note(normals[a, b], normal, ka, a, kb, b, world)
            is_near = bound >= need - MOST_GAINED
            if bound < need and wide > 0.0 and is_near:
                along = apart(normal, ka, a, kb, b, common, chain, bodies, world, spread)
                bound = max(bound, along)
        for side in range(2 if is_near else 0):
            if bound < need and _is_known(normals, a, b, side):
                seen, R = normals[a, b, side], world.turns[ka, a]
                if side == 1:
                    R = world.turns[kb, b]
                for i in range(3):
                    normal[i] = R[i, 0] * seen[0] + R[i, 1] * seen[1] + R[i, 2] * seen[2]
                along = apart(normal, ka, a, kb, b, common, chain, bodies, world, spread)
                bound = max(bound, along)
        if not bound >= need:
            left[count], lower[count], moves[count], whole_bounds[count] = n, low, far, bound
            count += 1
        elif asked.shown[pair]:
            bounds[place] = min(bounds[place], bound)
    return count


@njit_in_place
def _is_known(normals: Floats, a: int, b: int, side: int) -> bool:  # pragma: no cover (compiled)
    """Whether a direction is known in which two bodies were apart, as one of them sees it."""
    known = normals[a, b, side]
    return bool(known[0] != 0.0 or known[1] != 0.0 or known[2] != 0.0)


@njit_in_place
def _note(
    known: Floats, normal: Floats, ka: int, a: int, kb: int, b: int, world: BodyPoses
) -> None:  # pragma: no cover (compiled)
    """Note a direction (3,) as both bodies see it (2, 3)."""
    for i in range(3):
        known[0, i], known[1, i] = 0.0, 0.0
        for j in range(3):
            known[0, i] += world.turns[ka, a, j, i] * normal[j]
            known[1, i] += world.turns[kb, b, j, i] * normal[j]


@njit(cache=True)
def planes(
    items: Ints,
    ways: Floats,
    asked: PairQuery,
    normals: Floats,
    chain: JointTree,
    bodies: Bodies,
    world: BodyPoses,
    spread: SetExtents,
) -> Floats:  # pragma: no cover (compiled)
    """How far pairs are apart at least (n,) [m] in whole sets, seen along directions.

    Args:
        items: (n, 3) in which two of the sets, and which of the pairs, see `Batch`.
        ways: (n, 3) [m] from the nearest point of the one to that of the other, at the middle.
        asked: the pairs.
        normals: see `sieve`; the directions are noted in it.
        chain: the joints.
        bodies: all bodies.
        world: where everything is at the middles of the sets.
        spread: the sets.
    """
    bounds = np.full(len(items), -np.inf)
    for n in range(len(items)):
        ka, kb, pair = int(items[n, 0]), int(items[n, 1]), int(items[n, 2])
        a, b = int(asked.first[pair]), int(asked.second[pair])
        length = np.sqrt((ways[n] ** 2).sum())
        # Of bodies that just touch, Coal may not know it.
        if not 0.0 < length < np.inf:
            continue
        normal = ways[n] / length
        _note(normals[a, b], normal, ka, a, kb, b, world)
        common = int(asked.commons[pair])
        bounds[n] = apart(normal, ka, a, kb, b, common, chain, bodies, world, spread)
    return bounds


@njit_in_place
def _off(
    ka: int, a: int, kb: int, b: int, bodies: Bodies, world: BodyPoses
) -> float:  # pragma: no cover (compiled)
    """How far [m] the ball around a body is from the box around another one, or how deep in it."""
    R, square, deep = world.turns[kb, b], 0.0, np.inf
    for i in range(3):
        along = 0.0
        for m in range(3):
            along += R[m, i] * (world.centres[ka, a, m] - world.centres[kb, b, m])
        beyond = abs(along) - bodies.halves[b, i]
        square += max(beyond, 0.0) ** 2
        deep = min(deep, -beyond)
    return float((np.sqrt(square) if square > 0.0 else -deep) - bodies.radii[a])
