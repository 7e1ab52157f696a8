"""Whether two convex bodies are far enough apart: compiled, and only as exact as the answer needs.

Gilbert, Johnson and Keerthi, "A fast procedure for computing the distance between complex
objects in three-dimensional space" (1988), on the difference of two bodies.  Every step gives a
bound of the distance from below (a plane between the bodies) and from above (two points of
them); the search ends as soon as these tell on which side of the two limits it lies.

Where two bodies are not clear that only go around pieces, these are checked.
"""

from typing import cast

import numpy as np

from workbench.model.geometry import Floats
from workbench.planning.collision.bounds import PairDrift, nearing
from workbench.planning.collision.distances.cores import Cores
from workbench.planning.compiled import njit_in_place

TOUCHES, UNCLEAR, CLEAR = 0, 1, 2

MOST_STEPS = 48
"""Steps of the search; round bodies need some ten, polyhedra fewer."""

CLOSE_ENOUGH = 1e-7
"""[m] Bounds that lie as close together count as the distance."""

ROWS = 15
"""Of the scratch that is handed in; compiled code does not check their count."""

FIRST, ONE, TWO, THREE = cast(tuple[int, ...], (*map(np.int64, range(4)),))
"""Arguments with a type of their own: numba compiles a function anew for each plain number."""


@njit_in_place
def side(
    a: int,
    b: int,
    R: Floats,
    c: Floats,
    cores: Cores,
    low: float,
    high: float,
    W: Floats,
) -> int:
    """On which side of two limits the distance of bodies a and b lies.

    Args:
        a: one body.
        b: the other.
        R: rotations (b, 3, 3) of all bodies.
        c: centres (b, 3) of all bodies [m].
        cores: of all bodies.
        low: [m] nearer than this they touch.
        high: [m] at least this far they are clear; not below `low`.
        W: scratch (`ROWS`, 3).

    Returns:
        `TOUCHES`, `UNCLEAR` (between the limits) or `CLEAR`.
    """
    more = high - low
    still = PairDrift(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, more, more)
    return side_within(a, b, R, c, c, cores, low, still, W)


@njit_in_place
def side_within(
    a: int,
    b: int,
    R: Floats,
    c: Floats,
    half: Floats,
    cores: Cores,
    low: float,
    drift: PairDrift,
    W: Floats,
) -> int:
    """As `side`, its upper limit being what two bodies need that move against each other.

    That is `low` and by how much they can come nearer along the direction in which they are apart;
    `half` (b, 3) [m] are half the sizes of all bodies' boxes.
    """
    answer = _side_of(a, a, b, b, R, c, half, cores, low, drift, W)
    first, second = cores.pieces[a], cores.pieces[b]
    if answer == CLEAR or first + second == 0:
        return answer
    answer, needed = CLEAR, low + drift.most
    for m in range(max(first, 1)):
        k = cores.first[a] + m if first else a
        if first and _is_beyond(a, k, b, b, R, c, cores, needed):
            continue
        for n in range(max(second, 1)):
            i = cores.first[b] + n if second else b
            if _is_beyond(b, i, a, k, R, c, cores, needed):
                continue
            if first and second and _is_beyond(a, k, b, i, R, c, cores, needed):
                continue
            found = _side_of(a, k, b, i, R, c, half, cores, low, drift, W)
            if found == TOUCHES:
                return TOUCHES
            if found == UNCLEAR:
                answer = UNCLEAR
    return answer


@njit_in_place
def _is_beyond(
    a: int, k: int, b: int, i: int, R: Floats, c: Floats, cores: Cores, needed: float
) -> bool:
    """Whether the ball around core k of body a is `needed` [m] from the box around core i of b."""
    x, y, z = c[a, 0] - c[b, 0], c[a, 1] - c[b, 1], c[a, 2] - c[b, 2]
    for n in range(3):
        x += R[a, 0, n] * cores.middle[k, n]
        y += R[a, 1, n] * cores.middle[k, n]
        z += R[a, 2, n] * cores.middle[k, n]
    square = 0.0
    for m in range(3):
        along = -cores.middle[i, m]
        along += R[b, 0, m] * x
        along += R[b, 1, m] * y
        along += R[b, 2, m] * z
        out = max(abs(along) - cores.halves[i, m], 0.0)
        square += out * out
    reach = cores.ball[k] + needed
    return bool(reach < 0.0 or square >= reach * reach)


@njit_in_place
def _side_of(
    a: int,
    k: int,
    b: int,
    i: int,
    R: Floats,
    c: Floats,
    half: Floats,
    cores: Cores,
    low: float,
    drift: PairDrift,
    W: Floats,
) -> int:
    """As `side_within`, of core k of body a and core i of body b."""
    low += cores.swell[k] + cores.swell[i]
    x, y, z = c[a, 0] - c[b, 0], c[a, 1] - c[b, 1], c[a, 2] - c[b, 2]
    if x * x + y * y + z * z < 1e-18:
        x = 1.0
    n = FIRST
    below = -1.0
    for _ in range(MOST_STEPS):
        _support(a, k, R, c, cores, -x, -y, -z, 1.0, W, 4)
        _support(b, i, R, c, cores, x, y, z, -1.0, W, 4)
        norm = np.sqrt(x * x + y * y + z * z)
        plane = (x * W[4, 0] + y * W[4, 1] + z * W[4, 2]) / norm
        below = max(below, plane)
        come = nearing(drift, a, b, x / norm, y / norm, z / norm, R, half)
        if plane >= low + come:
            return CLEAR
        # Nothing further in this direction: the point found before is the nearest.
        if n > 0 and (norm - below <= CLOSE_ENOUGH or _is_known(W, n)):
            break
        for m in range(3):
            W[n, m] = W[4, m]
        n = _nearest(W, n + 1)
        if n == 0:
            return TOUCHES  # the origin is inside: the cores meet
        x, y, z = W[4, 0], W[4, 1], W[4, 2]
        above = np.sqrt(x * x + y * y + z * z)
        if above < 1e-12:
            return TOUCHES
        if above < low:
            return TOUCHES
        if below >= low and above < low + come:
            return UNCLEAR
    return TOUCHES if below < low else UNCLEAR


@njit_in_place
def _support(
    g: int,
    n: int,
    R: Floats,
    c: Floats,
    cores: Cores,
    x: float,
    y: float,
    z: float,
    sign: float,
    W: Floats,
    row: int,
) -> None:
    """Put the point of core n of body g furthest along (x, y, z) in a row of W, or take it off."""
    u = R[g, 0, 0] * x + R[g, 1, 0] * y + R[g, 2, 0] * z
    v = R[g, 0, 1] * x + R[g, 1, 1] * y + R[g, 2, 1] * z
    w = R[g, 0, 2] * x + R[g, 1, 2] * y + R[g, 2, 2] * z
    if cores.size[n] == 0:
        flat = np.sqrt(u * u + v * v)
        if flat > 1e-12:
            px, py = u / flat * cores.radius[n], v / flat * cores.radius[n]
        else:
            px, py = 0.0, 0.0
        pz = cores.length[n] if w >= 0 else -cores.length[n]
    else:
        best, at = -1e30, cores.start[n]
        for k in range(cores.start[n], cores.start[n] + cores.size[n]):
            along = cores.corners[k, 0] * u + cores.corners[k, 1] * v + cores.corners[k, 2] * w
            if along > best:
                best, at = along, k
        px, py, pz = cores.corners[at, 0], cores.corners[at, 1], cores.corners[at, 2]
    for i in range(3):
        p = c[g, i] + R[g, i, 0] * px + R[g, i, 1] * py + R[g, i, 2] * pz
        W[row, i] = p if sign > 0 else W[row, i] - p


@njit_in_place
def _is_known(W: Floats, n: int) -> bool:
    known = False
    for k in range(n):
        known |= W[k, 0] == W[4, 0] and W[k, 1] == W[4, 1] and W[k, 2] == W[4, 2]
    return known


@njit_in_place
def _dot(W: Floats, i: int, j: int) -> float:
    return float(W[i, 0] * W[j, 0] + W[i, 1] * W[j, 1] + W[i, 2] * W[j, 2])


@njit_in_place
def _nearest(W: Floats, n: int) -> int:
    """Reduce the simplex of the first n rows to what holds its point nearest to the origin.

    That point goes to row 4.  Returns how many rows are left; 0 when the origin is inside.
    """
    if n == 1:
        for i in range(3):
            W[4, i] = W[0, i]
        return 1
    if n == 2:
        return _on_edge(W, FIRST, ONE)
    if n == 3:
        return _on_face(W, FIRST, ONE, TWO)
    return _in_solid(W)


@njit_in_place
def _keep(W: Floats, a: int, b: int, c: int, n: int, s: float, t: float, r: float) -> int:
    """Move rows a, b, c to the front, as far as n says, and their combination to row 4."""
    for i in range(3):
        x, y, z = W[a, i], W[b, i], W[c, i]
        W[4, i] = s * x + t * y + r * z
        W[0, i] = x
        if n > 1:
            W[1, i] = y
        if n > 2:
            W[2, i] = z
    return n


@njit_in_place
def _on_edge(W: Floats, a: int, b: int) -> int:
    aa, ab, bb = _dot(W, a, a), _dot(W, a, b), _dot(W, b, b)
    whole = aa - 2 * ab + bb
    t = (aa - ab) / whole if whole > 1e-24 else 0.0
    if t <= 0:
        return _keep(W, a, a, a, ONE, 1.0, 0.0, 0.0)
    if t >= 1:
        return _keep(W, b, b, b, ONE, 1.0, 0.0, 0.0)
    return _keep(W, a, b, b, TWO, 1.0 - t, t, 0.0)


@njit_in_place
def _on_face(W: Floats, a: int, b: int, c: int) -> int:
    """The regions of a triangle, after Ericson, "Real-Time Collision Detection", 5.1.5."""
    aa, ab, ac = _dot(W, a, a), _dot(W, a, b), _dot(W, a, c)
    bb, bc, cc = _dot(W, b, b), _dot(W, b, c), _dot(W, c, c)
    # From a, from b and from c to the origin, along ab and along ac.
    d1, d2 = aa - ab, aa - ac
    d3, d4 = ab - bb, ab - bc
    d5, d6 = ac - bc, ac - cc
    if d1 <= 0 and d2 <= 0:
        return _keep(W, a, a, a, ONE, 1.0, 0.0, 0.0)
    if d3 >= 0 and d4 <= d3:
        return _keep(W, b, b, b, ONE, 1.0, 0.0, 0.0)
    vc = d1 * d4 - d3 * d2
    if vc <= 0 and d1 >= 0 and d3 <= 0:
        t = d1 / (d1 - d3)
        return _keep(W, a, b, b, TWO, 1.0 - t, t, 0.0)
    if d6 >= 0 and d5 <= d6:
        return _keep(W, c, c, c, ONE, 1.0, 0.0, 0.0)
    vb = d5 * d2 - d1 * d6
    if vb <= 0 and d2 >= 0 and d6 <= 0:
        t = d2 / (d2 - d6)
        return _keep(W, a, c, c, TWO, 1.0 - t, t, 0.0)
    va = d3 * d6 - d5 * d4
    if va <= 0 and d4 - d3 >= 0 and d5 - d6 >= 0:
        t = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        return _keep(W, b, c, c, TWO, 1.0 - t, t, 0.0)
    whole = va + vb + vc
    if whole <= 0.0:  # three points on a line, which the edges have answered but for rounding
        return _on_edge(W, a, b)
    t, r = vb / whole, vc / whole
    return _keep(W, a, b, c, THREE, 1.0 - t - r, t, r)


@njit_in_place
def _in_solid(W: Floats) -> int:
    """The nearest face that the origin is outside of; 0 when there is none.

    It writes to the rows of W from the fifth on.
    """
    best, kept = 1e30, 0
    T, S = W[5:10], W[10:15]
    is_outside = False
    for face in range(4):
        a, b, c, d = (face + 1) % 4, (face + 2) % 4, (face + 3) % 4, face
        if not _beyond(W, a, b, c, d):
            continue
        is_outside = True
        for k in range(4):
            for i in range(3):
                T[k, i] = W[k, i]
        n = _on_face(T, a, b, c)
        far = T[4, 0] ** 2 + T[4, 1] ** 2 + T[4, 2] ** 2
        if far < best:
            best, kept = far, n
            for k in range(5):
                for i in range(3):
                    S[k, i] = T[k, i]
    if not is_outside:
        return 0
    for k in range(5):
        for i in range(3):
            W[k, i] = S[k, i]
    return kept


@njit_in_place
def _beyond(W: Floats, a: int, b: int, c: int, d: int) -> bool:
    """Whether a face parts the origin from the fourth corner d; also when the solid is flat."""
    e0, e1, e2 = W[b, 0] - W[a, 0], W[b, 1] - W[a, 1], W[b, 2] - W[a, 2]
    f0, f1, f2 = W[c, 0] - W[a, 0], W[c, 1] - W[a, 1], W[c, 2] - W[a, 2]
    n0, n1, n2 = e1 * f2 - e2 * f1, e2 * f0 - e0 * f2, e0 * f1 - e1 * f0
    origin = -(n0 * W[a, 0] + n1 * W[a, 1] + n2 * W[a, 2])
    other = n0 * (W[d, 0] - W[a, 0]) + n1 * (W[d, 1] - W[a, 1]) + n2 * (W[d, 2] - W[a, 2])
    return origin * other < 0 or abs(other) < 1e-18
