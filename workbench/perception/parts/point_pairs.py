"""Point-pair features: votes for poses of a surface in a cloud of oriented points.

After B. Drost, M. Ulrich, N. Navab, S. Ilic, "Model Globally, Match Locally: Efficient and
Robust 3D Object Recognition", CVPR 2010.  A pair of points with normals n1, n2 and difference
d has the feature (|d|, angle(n1, d), angle(n2, d), angle(n1, n2)), which no motion changes.
When a pair of the scene has the feature of a pair of the model, aligning the two gives exactly
one pose.  So each reference point of the scene collects votes for its model point and for the
angle about its normal.  Of points that the part's symmetry maps onto each other only one is used:
votes for the others are votes for the same poses.
"""

from dataclasses import dataclass

import numpy as np
from numba import int32, njit, prange, uint64
from numpy.typing import NDArray

from workbench.model.geometry import Floats, Ints, frozen, put
from workbench.perception.parts.oriented import OrientedPoints
from workbench.perception.views.motions import Triple, dot

Singles = NDArray[np.float32]

DISTANCES = 20
ANGLES = 15
TURN_BINS = 30
"""Bins for the distance up to the diameter, for each angle, and for the turn."""

LIMITS = np.append(np.cos(np.arange(1, ANGLES) * np.pi / ANGLES), -np.inf)
"""Cosines of the angles at which a bin ends."""

CELLS = 64
"""Cells between the cosines -1 and 1, each narrower than any bin."""

BIN_AT = np.array([np.count_nonzero(2.0 * (k + 1) / CELLS - 1.0 <= LIMITS) for k in range(CELLS)])
"""The bin of the largest cosine in each cell: what is smaller is in this one or in the next."""

FEWEST_VOTES = 3.0


@dataclass(frozen=True, slots=True, eq=False)
class PairTable:
    """All pairs of a reference point and any point of a model, sorted by feature.

    Entries `starts[f]` to `starts[f + 1]` have feature f: `firsts` (k,) is the index of the
    pair's first point among the `references`, `turns` (k,) [rad] where the second lies around the
    first one's normal.
    """

    model: OrientedPoints
    references: OrientedPoints
    diameter: float
    starts: np.ndarray
    firsts: np.ndarray
    turns: Singles

    def __post_init__(self) -> None:
        put(
            self,
            starts=frozen(self.starts, np.int64),
            firsts=frozen(self.firsts, np.int32),
            turns=frozen(self.turns, np.float32),
        )


def make_table(model: OrientedPoints, references: OrientedPoints, diameter: float) -> PairTable:
    """Features of all pairs of a reference and a point; `diameter` [m] is the longest."""
    features, firsts, turns = _pairs(
        references.points, references.normals, model.points, model.normals, diameter
    )
    order = np.argsort(features, kind="stable")
    starts = np.searchsorted(features[order], np.arange((DISTANCES + 1) * ANGLES**3 + 1))
    return PairTable(model, references, diameter, starts, firsts[order], turns[order])


def vote(
    table: PairTable, scene: OrientedPoints, references: np.ndarray, peaks: int
) -> tuple[Floats, Floats]:
    """Poses that the scene's point pairs vote for.

    Args:
        table: the model's pairs.
        scene: points of the scan.
        references: indices of the points that collect votes.
        peaks: how many poses each of them proposes at most, each with another reference.

    Returns:
        Poses (m, 4, 4) of the model in the frame of the scene, and their votes (m,).
    """
    poses, votes = _vote(
        table.references.points,
        table.references.normals,
        table.diameter,
        table.starts,
        table.firsts,
        table.turns,
        int(np.diff(table.starts).max()),
        scene.points,
        scene.normals,
        np.ascontiguousarray(references, dtype=np.int64),
        peaks,
    )
    return poses[votes > 0], votes[votes > 0]


@njit(cache=True)
def _angle(cosine: float) -> int:  # pragma: no cover (compiled)
    """The bin of an angle between 0 and 180 degrees; looked up, as an arc cosine takes longer."""
    cell = min(max(int((cosine + 1.0) * (CELLS / 2)), 0), CELLS - 1)
    found = BIN_AT[uint64(cell)]
    return found + (1 if cosine <= LIMITS[uint64(found)] else 0)


@njit(cache=True)
def _feature(
    p1: Triple, n1: Triple, p2: Triple, n2: Triple, diameter: float
) -> int:  # pragma: no cover (compiled)
    """The number of a pair's bin, or -1 when it is too long or has no length."""
    d = p2[0] - p1[0], p2[1] - p1[1], p2[2] - p1[2]
    length = np.sqrt(dot(d, d))
    if length > diameter or length < 1e-9:
        return -1
    number = int(length / diameter * DISTANCES)
    number = number * ANGLES + _angle(dot(n1, d) / length)
    number = number * ANGLES + _angle(dot(n2, d) / length)
    return number * ANGLES + _angle(dot(n1, n2))


@njit(cache=True)
def _frame(n: Floats) -> Floats:  # pragma: no cover (compiled)
    """A rotation with `n` as its first column (Duff et al., JCGT 6(1), 2017)."""
    sign = 1.0 if n[2] >= 0.0 else -1.0
    a = -1.0 / (sign + n[2])
    b = n[0] * n[1] * a
    return np.array(
        [
            [n[0], 1.0 + sign * n[0] * n[0] * a, b],
            [n[1], sign * b, sign + n[1] * n[1] * a],
            [n[2], -sign * n[0], -n[1]],
        ]
    )


@njit(cache=True)
def _turn(
    second: Triple, third: Triple, p1: Triple, p2: Triple
) -> float:  # pragma: no cover (compiled)
    """Where `p2` lies around the first axis of the frame at `p1` [rad], seen in its other two."""
    d = p2[0] - p1[0], p2[1] - p1[1], p2[2] - p1[2]
    return np.arctan2(dot(third, d), dot(second, d))


@njit(cache=True)
def _column(frame: Floats, k: int) -> Triple:  # pragma: no cover (compiled)
    return frame[0, k], frame[1, k], frame[2, k]


@njit(cache=True)
def _pairs(
    references: Floats, directions: Floats, points: Floats, normals: Floats, diameter: float
) -> tuple[Ints, Ints, Singles]:  # pragma: no cover (compiled)
    most = len(references) * len(points)
    features = np.empty(most, np.int64)
    firsts = np.empty(most, np.int32)
    turns = np.empty(most, np.float32)
    n = 0
    for i in range(len(references)):
        frame = _frame(directions[i])
        second, third = _column(frame, 1), _column(frame, 2)
        p1 = references[i, 0], references[i, 1], references[i, 2]
        n1 = directions[i, 0], directions[i, 1], directions[i, 2]
        for j in range(len(points)):
            p2 = points[j, 0], points[j, 1], points[j, 2]
            n2 = normals[j, 0], normals[j, 1], normals[j, 2]
            feature = _feature(p1, n1, p2, n2, diameter)
            if feature >= 0:
                features[n], firsts[n] = feature, i
                turns[n] = _turn(second, third, p1, p2)
                n += 1
    return features[:n], firsts[:n], turns[:n]


@njit(cache=True, parallel=True)
def _vote(
    model_points: Floats,
    model_normals: Floats,
    diameter: float,
    starts: Ints,
    firsts: Ints,
    turns: Singles,
    most: int,
    points: Floats,
    normals: Floats,
    references: Ints,
    peaks: int,
) -> tuple[Floats, Floats]:  # pragma: no cover (compiled)
    poses = np.empty((len(references), peaks, 4, 4))
    votes = np.zeros((len(references), peaks))
    for number in prange(len(references)):
        point, normal = points[references[number]], normals[references[number]]
        frame = _frame(normal)
        counts = _counts(
            len(model_points), point, normal, frame, diameter, starts, firsts, turns, most,
            points, normals,
        )  # fmt: skip
        best, heights = np.empty(len(counts), np.int64), np.empty(len(counts))
        for first in range(len(counts)):
            best[first] = counts[first].argmax()
            heights[first] = counts[first, best[first]]
        for peak in range(min(peaks, len(counts))):
            first = heights.argmax()
            turn, height = best[first], heights[first]
            if height < FEWEST_VOTES:
                break
            heights[first] = -1.0
            before, after = counts[first, turn - 1], counts[first, (turn + 1) % TURN_BINS]
            angle = (turn + (after - before) / (before + height + after)) / TURN_BINS * 2.0 * np.pi
            c, s = np.cos(angle), np.sin(angle)
            model_frame = _frame(model_normals[first])
            # The frame turned about its first axis, times the other one's inverse.
            for i in range(3):
                second = c * frame[i, 1] + s * frame[i, 2]
                third = c * frame[i, 2] - s * frame[i, 1]
                place = point[i]
                for k in range(3):
                    share = frame[i, 0] * model_frame[k, 0]
                    share += second * model_frame[k, 1] + third * model_frame[k, 2]
                    poses[number, peak, i, k] = share
                    place -= share * model_points[first, k]
                poses[number, peak, i, 3] = place
                poses[number, peak, 3, i] = 0.0
            poses[number, peak, 3, 3] = 1.0
            votes[number, peak] = height
    return poses, votes


@njit(cache=True)
def _counts(
    size: int,
    point: Floats,
    normal: Floats,
    frame: Floats,
    diameter: float,
    starts: Ints,
    firsts: Ints,
    turns: Singles,
    most: int,
    points: Floats,
    normals: Floats,
) -> Singles:  # pragma: no cover (compiled)
    """Votes (size, TURNS) of one reference point: which point of the model, and which turn.

    No feature has more than `most` entries.
    """
    counts = np.zeros(size * TURN_BINS, np.float32)
    shares = np.empty(most)
    lowers, uppers = np.empty(most, np.int32), np.empty(most, np.int32)
    per_turn, bins = TURN_BINS / (2.0 * np.pi), int32(TURN_BINS)
    p1, n1 = (point[0], point[1], point[2]), (normal[0], normal[1], normal[2])
    second, third = _column(frame, 1), _column(frame, 2)
    for other in range(len(points)):
        p2 = points[other, 0], points[other, 1], points[other, 2]
        n2 = normals[other, 0], normals[other, 1], normals[other, 2]
        feature = _feature(p1, n1, p2, n2, diameter)
        if feature < 0 or starts[feature] == starts[feature + 1]:
            continue
        turn = _turn(second, third, p1, p2)
        start = uint64(starts[feature])
        entries = uint64(starts[feature + 1]) - start
        # First where all votes go, several at a time, then the votes, which go one by one.
        for k in range(entries):
            place = (turn - turns[start + k]) * per_turn
            floor = np.floor(place)
            shares[k] = place - floor
            # Two turns are less than one round apart, either way: a division would take longer.
            lower = int32(floor)
            lower = int32(lower + (bins if lower < 0 else int32(0)))
            lower = int32(lower - (bins if lower >= bins else int32(0)))
            upper = int32(lower + 1) if lower + 1 < bins else int32(0)
            row = int32(firsts[start + k] * bins)
            lowers[k], uppers[k] = row + lower, row + upper
        for k in range(entries):
            counts[uint64(lowers[k])] += 1.0 - shares[k]
            counts[uint64(uppers[k])] += shares[k]
    return counts.reshape(size, TURN_BINS)
