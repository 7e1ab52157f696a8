"""One look: which pairs of bodies a motion around a state may bring too near to each other."""

from typing import NamedTuple, cast

import numpy as np

from workbench.model.geometry import Floats, Ints
from workbench.planning.collision.bounds import Boxes, PairDrift, lower_bound, nearing, out_of_box
from workbench.planning.collision.distances.cores import BALL, Cores
from workbench.planning.collision.distances.gjk import CLEAR, TOUCHES, UNCLEAR, side_within
from workbench.planning.collision.sweeping.balls import ball_gap, has_formula
from workbench.planning.collision.sweeping.groups import Groups
from workbench.planning.collision.sweeping.scratch import Scratch, place_body, place_joints
from workbench.planning.compiled import njit_in_place
from workbench.planning.kinematics.robot import JointTree

LOOSENESS = 0.005
"""[m] By about this much the lower bound of a distance falls short; only a matter of speed."""

WIDE_MOTION = 0.5
"""Where links move by more than this share of the radii around them: none of their bodies is
checked for how far it moves, only for what touches; only a matter of speed."""

IS_CLEAR, TOO_LONG = -1, -2

FIRST, ANY, NAMED = cast(int, np.int64(0)), cast(bool, np.False_), cast(bool, np.True_)
"""Arguments with a type of their own: numba compiles a function anew for each plain 0 or True."""


class Model(NamedTuple):
    """Kinematics, boxes and cores of all bodies, and the pairs of them.

    `first` and `second` (k,) are indices of bodies: the two of each pair.
    """

    tree: JointTree
    boxes: Boxes
    first: Ints
    second: Ints
    cores: Cores


@njit_in_place
def look_at(
    begin: int,
    asked: int,
    used: int,
    margins: Floats,
    commons: Ints,
    model: Model,
    groups: Groups,
    scratch: Scratch,
    names: bool,
) -> tuple[int, int, float]:
    """Look at pairs at the state `scratch.q` for a motion of up to `scratch.d` around it.

    Those numbered from `begin` on, `asked` of the open ones, are checked; what the motion may
    bring closer than its margin is written behind the first `used`.  A group among them stands as
    its number below zero, counted from -1 down.  `margins` (p,) [m] and `commons` (p,) are those of
    all pairs.

    Returns:
        A pair that touches, `IS_CLEAR` or `TOO_LONG`; how many open pairs are in use; the largest
        motion bound of those that were kept [m].
    """
    # Arrays by themselves: to hand on all of a scratch takes longer than most of what is done here.
    boxes, cores, open_pairs = model.boxes, model.cores, scratch.open_pairs
    joint, radius, half, R_g, c_g = boxes.joint, boxes.radius, boxes.half, boxes.R, boxes.c
    form, swell, flat, length = cores.form, cores.swell, cores.radius, cores.length
    R_j, p_j, twist, hub, hub_c = (
        scratch.R_j,
        scratch.p_j,
        scratch.twist,
        scratch.hub,
        scratch.hub_c,
    )
    hub_most, hub_rest = scratch.hub_most, scratch.hub_rest
    most, rest = scratch.most, scratch.rest
    R, c, placed, normal, W = scratch.R, scratch.c, scratch.placed, scratch.normal, scratch.W
    place_joints(model.tree, scratch)
    # Number of this look: what stands in `placed` for a body or more is where it is now.
    scratch.look[0] += 1
    look = scratch.look[0]
    touching, kept, furthest = IS_CLEAR, used, 0.0
    for at in range(begin, begin + asked):
        entry, first, last, is_wide = open_pairs[at], 0, 1, False
        if entry < 0:
            first, last = groups.begins[-1 - entry], groups.begins[-entry]
            if last - first > 1:
                k = groups.pairs[first]
                a, b, common = int(model.first[k]), int(model.second[k]), int(commons[k])
                i, j, margin = int(joint[a]), int(joint[b]), float(groups.margins[-1 - entry])
                apart = _hubs_apart(a, b, i, j, hub, hub_c, R, c, half, normal)
                move = float(hub_most[i, common] + hub_most[j, common])
                if apart >= margin + move:
                    continue
                if apart >= 0.0:
                    beside = float(hub_rest[i, common] + hub_rest[j, common])
                    drift = drift_of(i, j, i, j, common, NAMED, NAMED, beside, move, hub_c, twist)
                    x, y, z = float(normal[0]), float(normal[1]), float(normal[2])
                    move = nearing(drift, a, b, x, y, z, R, half)
                    if apart >= margin + move:
                        continue
                is_wide = move > WIDE_MOTION * (hub[i, 3] + hub[j, 3])
                if is_wide:
                    if kept >= len(open_pairs):
                        return TOO_LONG, kept, furthest
                    open_pairs[kept] = entry
                    kept += 1
                    furthest = max(furthest, float(most[i, common] + most[j, common]))
                    if apart >= margin:
                        continue
        for number in range(first, last):
            k = groups.pairs[number] if entry < 0 else entry
            a, b, common = int(model.first[k]), int(model.second[k]), int(commons[k])
            i, j, margin = int(joint[a]), int(joint[b]), float(margins[k])
            for g, on in ((a, i), (b, j)):
                if placed[g] < look:
                    place_body(g, on, form[g] == BALL, R_g, c_g, R_j, p_j, R, c)
                    placed[g] = look
            # By far the most pairs end here: balls around both, and what their links may move.
            move = 0.0 if is_wide else float(most[i, common] + most[j, common])
            x, y, z = c[a, 0] - c[b, 0], c[a, 1] - c[b, 1], c[a, 2] - c[b, 2]
            far, reach = x * x + y * y + z * z, radius[a] + radius[b] + margin + move
            if reach > 0 and far > reach * reach:
                continue
            answer, beside = UNCLEAR, min(move, float(rest[i, common] + rest[j, common]))
            if has_formula(a, b, form):
                apart = ball_gap(a, b, R, c, half, form, swell, flat, length, normal)
                if apart < margin:
                    answer = TOUCHES
                elif apart >= margin + beside and not is_wide:
                    turns = form[a] == BALL, form[b] == BALL
                    drift = drift_of(a, b, i, j, common, *turns, beside, move, c, twist)
                    x, y, z = float(normal[0]), float(normal[1]), float(normal[2])
                    if apart >= margin + nearing(drift, a, b, x, y, z, R, half):
                        answer = CLEAR
            else:
                lower = lower_bound(a, b, R, c, half, radius, margin + move)
                if lower >= margin + move:
                    continue
                # Clear now, and too far to go to be cleared by measuring: not worth it.
                if not margin <= lower < margin + move / 2 - LOOSENESS:
                    turns = form[a] == BALL, form[b] == BALL
                    drift = drift_of(a, b, i, j, common, *turns, beside, move, c, twist)
                    answer = side_within(a, b, R, c, half, cores, margin, drift, W)
            if answer == TOUCHES:
                if not names:
                    return int(k), kept, furthest
                touching = int(k) if touching < 0 else min(touching, int(k))
            elif answer == UNCLEAR and not is_wide:
                if kept >= len(open_pairs):
                    return TOO_LONG, kept, furthest
                open_pairs[kept] = k
                kept += 1
                furthest = max(furthest, move)
    return touching, kept, furthest


@njit_in_place
def _hubs_apart(
    a: int,
    b: int,
    i: int,
    j: int,
    hub: Floats,
    hub_c: Floats,
    R: Floats,
    c: Floats,
    half: Floats,
    normal: Floats,
) -> float:
    """How far [m] the hubs of bodies a, b on joints i, j are apart; of what stands, its own box.

    Where they are, the direction (3,) is written to `normal`.
    """
    if i == 0:
        i, j, b = j, i, a
    x, y, z = hub_c[i, 0], hub_c[i, 1], hub_c[i, 2]
    if j == 0:
        x, y, z, far = out_of_box(x, y, z, b, R, c, half)
    else:
        x, y, z = x - hub_c[j, 0], y - hub_c[j, 1], z - hub_c[j, 2]
        far = np.sqrt(x * x + y * y + z * z)
    if far > 0.0:
        normal[0], normal[1], normal[2] = x / far, y / far, z / far
    return float(far - hub[i, 3] - hub[j, 3])


@njit_in_place
def drift_of(
    a: int,
    b: int,
    i: int,
    j: int,
    common: int,
    is_ball: bool,
    is_other_ball: bool,
    rest: float,
    most: float,
    c: Floats,
    twist: Floats,
) -> PairDrift:
    """How what is around `c[a]` on joint i moves against what is around `c[b]` on joint j.

    Seen from the link of the joint `common`, which carries both.  However a ball turns, it is where
    it is.  `rest` and `most` [m] are those of the `PairDrift`, `c` (b, 3) [m] are centres and
    `twist` (j, 6) [m, rad] is that of `Scratch`.
    """
    s, t, u = twist[common, 3], twist[common, 4], twist[common, 5]
    p, q, r = twist[i, 3] - s, twist[i, 4] - t, twist[i, 5] - u
    s, t, u = twist[j, 3] - s, twist[j, 4] - t, twist[j, 5] - u
    x = twist[i, 0] - twist[j, 0] + q * c[a, 2] - r * c[a, 1] - t * c[b, 2] + u * c[b, 1]
    y = twist[i, 1] - twist[j, 1] + r * c[a, 0] - p * c[a, 2] - u * c[b, 0] + s * c[b, 2]
    z = twist[i, 2] - twist[j, 2] + p * c[a, 1] - q * c[a, 0] - s * c[b, 1] + t * c[b, 0]
    if is_ball:
        p, q, r = 0.0, 0.0, 0.0
    if is_other_ball:
        s, t, u = 0.0, 0.0, 0.0
    return PairDrift(x, y, z, p, q, r, s, t, u, rest, most)
