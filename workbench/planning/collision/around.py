"""Whether hands, or parts, meet what stands around them: compiled, one way after the other."""

from typing import NamedTuple

import numpy as np
from numba import njit

from workbench.model.geometry import Bools, Floats, Ints
from workbench.planning.collision.distances.cores import Cores
from workbench.planning.collision.distances.gjk import ROWS, TOUCHES, side
from workbench.planning.collision.hands import NO_PAIR, Hands
from workbench.planning.compiled import njit_in_place

OPEN, CLOSED = 0, 1


class Around(NamedTuple):
    """The solids of a tool (t, ...) seen from its flange, and what stands around it (s, ...) [m].

    `cores` are those of the tool's solids and then those of the rest; `owner` (s,) is the number of
    the part that a piece belongs to, -1 for others.  `way` (t, 3) is where a finger moves as it
    opens; `size` (t, 3) and `half` (s, 3) are half sizes of boxes, `radius` (t,) of balls.
    """

    R_tool: Floats
    p_tool: Floats
    way: Floats
    size: Floats
    radius: Floats
    R_still: Floats
    c_still: Floats
    half: Floats
    owner: Ints
    cores: Cores


class Places(NamedTuple):
    """Parts to be taken, and what stands near each of them.

    `R` (d, 3, 3) and `p` (d, 3) [m] are where they lie, `number` (d,) those of the detections;
    `first` (d,) is the number among what stands around of the part's first piece.  Near part d are
    `near` from `start[d]` (d + 1,) on.
    """

    R: Floats
    p: Floats
    number: Ints
    first: Ints
    near: Ints
    start: Ints


@njit(cache=True)
def first_fits(
    hands: Hands,
    grasp: Ints,
    place: Ints,
    pieces: int,
    places: Places,
    margin: float,
    around: Around,
) -> tuple[Ints, Ints]:
    """For each candidate its first way that fits, and the first contact of its first way.

    Args:
        hands: of the part.
        grasp: (c,) numbers of grasps.
        place: (c,) numbers of places; candidates of one place follow each other.
        pieces: of the part.
        places: poses of the parts.
        margin: [m] to everything except the part itself.
        around: tool and surroundings.

    Returns:
        Numbers of ways (c,), -1 if none fits; and contacts (c, 3): `OPEN` or `CLOSED`; the pair or
        `NO_PAIR`; 1 for touching, 0 for too near.  The pair is the index of the tool's solid times
        the number of bodies around, plus the index of the body.
    """
    R, c, W = _scratch(around)
    tools, still = len(around.radius), len(around.owner)
    fits = np.full(len(grasp), -1)
    met = np.full((len(grasp), 3), NO_PAIR)
    last = np.full(2, -1)
    for k in range(len(grasp)):
        begin, end = hands.first[grasp[k]], hands.first[grasp[k] + 1]
        blocked = np.zeros(end - begin, np.bool_)
        if k == 0 or place[k] != place[k - 1]:
            last[:] = -1
        for w in range(begin, end):
            if blocked[hands.turn[w]]:
                continue
            phase, code = _first_met(
                hands, w, place[k], pieces, places, margin, around, w == begin, last, R, c, W
            )
            if code == NO_PAIR:
                fits[k] = w
                break
            if w == begin:
                met[k, 0], met[k, 1] = phase, code
                t, s = code // still, tools + code % still
                met[k, 2] = side(t, s, R, c, around.cores, 0.0, 0.0, W) == TOUCHES
            if code != NO_PAIR and last[0] >= 0 and _stands(around, last[0]):
                # No other opening moves what is in the way of the palm.
                blocked[hands.turn[w]] = True
    return fits, met


@njit(cache=True)
def which_fit(hands: Hands, pieces: int, places: Places, margin: float, around: Around) -> Bools:
    """Which ways fit at one place (w,), twice as fast as `first_fits`: any pair that meets will do.

    Args:
        hands: of the part.
        pieces: of the part.
        places: of one part.
        margin: [m] kept to everything but the part itself.
        around: tool and surroundings.
    """
    R, c, W = _scratch(around)
    fits = np.empty(len(hands.turn), np.bool_)
    last = np.full(2, -1)
    # For a literal 0 or False numba would compile `_first_met` once more.
    place = np.zeros(1, np.int64)
    for w in range(len(fits)):
        _, code = _first_met(
            hands, w, place[0], pieces, places, margin, around, w < 0, last, R, c, W
        )
        fits[w] = code == NO_PAIR
    return fits


@njit(cache=True)
def _scratch(around: Around) -> tuple[Floats, Floats, Floats]:
    """Scratch for rotations and centres, of the tool's solids and then of what stands around."""
    tools, still = len(around.radius), len(around.owner)
    R, c = np.empty((tools + still, 3, 3)), np.empty((tools + still, 3))
    for g in range(still):
        for i in range(3):
            c[tools + g, i] = around.c_still[g, i]
            for j in range(3):
                R[tools + g, i, j] = around.R_still[g, i, j]
    return R, c, np.empty((ROWS, 3))


@njit_in_place
def _stands(around: Around, t: int) -> bool:
    """Whether a solid of the tool is where it is however far the fingers are open."""
    return bool(around.way[t, 0] == 0.0 and around.way[t, 1] == 0.0 and around.way[t, 2] == 0.0)


@njit(cache=True)
def _first_met(
    hands: Hands,
    w: int,
    d: int,
    pieces: int,
    places: Places,
    margin: float,
    around: Around,
    is_first_asked: bool,
    last: Ints,
    R: Floats,
    c: Floats,
    W: Floats,
) -> tuple[int, int]:
    """What a hand meets in one of its ways, the first pair with `is_first_asked`, or else any.

    `last` (2,) is the pair that was met last, as it is likely to be met again; -1 for a cut into
    the part itself.
    """
    tools, still = len(around.radius), len(around.owner)
    has_fingers = False
    for t in range(tools):
        has_fingers |= not _stands(around, t)
    number, near = places.number[d], places.near[places.start[d] : places.start[d + 1]]
    for phase in range(OPEN if has_fingers else CLOSED, 2):
        cut = hands.cuts[w, phase]
        if cut != NO_PAIR:
            cut = (cut // pieces) * still + places.first[d] + cut % pieces
            if not is_first_asked:
                last[:] = -1
                return phase, cut
        _put(
            places.R[d], places.p[d], hands.R[w], hands.p[w], hands.opening[w, phase],
            around, R, c,
        )  # fmt: skip
        if not is_first_asked and last[0] >= 0:
            again = _first_near(last[0], last[1:], number, margin, around, R, c, W)
            if again >= 0:
                return phase, last[0] * still + again
        for t in range(tools):
            if t * still > cut or (phase == CLOSED and has_fingers and _stands(around, t)):
                continue  # the cut comes first, or it was clear already
            g = _first_near(t, near, number, margin, around, R, c, W)
            if g >= 0 and t * still + g < cut:
                last[0], last[1] = t, g
                return phase, t * still + g
        if cut != NO_PAIR:
            last[:] = -1
            return phase, cut
    return 0, NO_PAIR


@njit(cache=True)
def _put(
    R_a: Floats,
    p_a: Floats,
    R_b: Floats,
    p_b: Floats,
    opening: float,
    around: Around,
    R: Floats,
    c: Floats,
) -> None:
    """Put the solids of a tool where they are when its flange is at T_a * T_b."""
    turn, at = np.empty((3, 3)), np.empty(3)
    for i in range(3):
        at[i] = p_a[i]
        for j in range(3):
            at[i] += R_a[i, j] * p_b[j]
            turn[i, j] = 0.0
            for m in range(3):
                turn[i, j] += R_a[i, m] * R_b[m, j]
    for t in range(len(around.radius)):
        for i in range(3):
            place = at[i]
            for j in range(3):
                place += turn[i, j] * (around.p_tool[t, j] + around.way[t, j] * opening / 2.0)
                across = 0.0
                for m in range(3):
                    across += turn[i, m] * around.R_tool[t, m, j]
                R[t, i, j] = across
            c[t, i] = place


@njit_in_place
def _first_near(
    t: int,
    near: Ints,
    own: int,
    margin: float,
    around: Around,
    R: Floats,
    c: Floats,
    W: Floats,
) -> int:
    """The first of the numbers `near` whose body is nearer than the margin to solid t; or -1.

    Pieces of the part `own` are left out.
    """
    tools = len(around.radius)
    for g in near:
        if around.owner[g] == own:
            continue
        s = tools + g
        x, y, z = c[t, 0] - c[s, 0], c[t, 1] - c[s, 1], c[t, 2] - c[s, 2]
        gap = 0.0
        for i in range(3):
            along = abs(R[s, 0, i] * x + R[s, 1, i] * y + R[s, 2, i] * z)
            out = max(along - around.half[g, i], 0.0)
            gap += out * out
        if np.sqrt(gap) - around.radius[t] >= margin:
            continue
        is_parted = False
        for i in range(3):  # the faces of their boxes
            far = abs(R[s, 0, i] * x + R[s, 1, i] * y + R[s, 2, i] * z) - around.half[g, i]
            back = abs(R[t, 0, i] * x + R[t, 1, i] * y + R[t, 2, i] * z) - around.size[t, i]
            for j in range(3):
                far -= around.size[t, j] * abs(
                    R[s, 0, i] * R[t, 0, j] + R[s, 1, i] * R[t, 1, j] + R[s, 2, i] * R[t, 2, j]
                )
                back -= around.half[g, j] * abs(
                    R[t, 0, i] * R[s, 0, j] + R[t, 1, i] * R[s, 1, j] + R[t, 2, i] * R[s, 2, j]
                )
            is_parted |= far >= margin or back >= margin
        if not is_parted and side(t, s, R, c, around.cores, margin, margin, W) == TOUCHES:
            return g
    return -1


@njit(cache=True)
def first_contact(
    R: Floats, p: Floats, opening: float, own: int, margin: float, around: Around
) -> tuple[int, int]:
    """The first place on a way at which a tool, or a part, has a pair nearer than the margin.

    Args:
        R: rotation (3, 3) of the tool's flange, or of the part.
        p: its places (k, 3) [m], in their order.
        opening: [m] of the fingers.
        own: number of the part that is left out.
        margin: [m] that is kept.
        around: tool or part, and surroundings.

    Returns:
        The number of the place, -1 when there is none; and solid of the tool times what stands
        around plus the number there, or `NO_PAIR`.
    """
    R_all, c, W = _scratch(around)
    still = len(around.owner)
    every, identity, none = np.arange(still), np.eye(3), np.zeros(3)
    for k in range(len(p)):
        _put(R, p[k], identity, none, opening, around, R_all, c)
        for t in range(len(around.radius)):
            g = _first_near(t, every, own, margin, around, R_all, c, W)
            if g >= 0:
                return k, t * still + g
    return -1, NO_PAIR
