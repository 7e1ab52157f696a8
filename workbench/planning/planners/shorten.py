"""What is done with a path once it is found: shortened, tiny corners merged, divided evenly."""

import numpy as np
from numba import njit

from workbench.model.geometry import Floats
from workbench.planning.collision.sweeping.edges import ASK, CLEAR, Edges
from workbench.planning.planners.asking import RecordedAnswers, asking, look_up, write_row
from workbench.plugins.planner import EdgeCheck

CUTS = (0.8, 0.5, 0.25)
"""Shares of the segments at a corner that a cut may leave out, tried in this order."""

TINY = np.deg2rad(2.0)
"""[rad] Corners closer together than this in every joint count as one."""

CORNER_CUTS = 2
"""How often all corners are cut: each cut leaves two flatter ones."""

NO_CUTS = -1
"""As the most waypoints: the path is not cut, only skipped along."""


def shorten_path(path: Floats, is_clear: EdgeCheck, *, most: int) -> Floats:
    """The same path (m, n) [rad] with detours cut: waypoints skipped, then corners cut off.

    From each remaining waypoint it goes straight to the furthest reachable one.  Then each corner
    gets the widest clear cut of some.  This repeats `CORNER_CUTS` times, or ends before there could
    be more than `most` waypoints.
    """
    count, joints = path.shape
    questions = count * count + CORNER_CUTS * len(CUTS) * max(most, count)
    return asking(
        lambda edges, answers: _shorten(path, most, edges, answers), is_clear, joints, questions
    )


def skip_waypoints(path: Floats, is_clear: EdgeCheck) -> Floats:
    """The same path (m, n) [rad], from each kept waypoint straight on to the furthest possible."""
    count, joints = path.shape
    return asking(
        lambda edges, answers: _shorten(path, NO_CUTS, edges, answers),
        is_clear,
        joints,
        count * count,
    )


@njit(cache=True)
def _shorten(path: Floats, most: int, edges: Edges, answers: RecordedAnswers) -> Floats:
    path = _skip(path, edges, answers)
    for _ in range(CORNER_CUTS):
        if len(path) > 0 and 2 * len(path) - 2 <= most:
            path = _cut(path, edges, answers)
    return path


# Part of `_shorten`: otherwise all that answers its questions is compiled once more.
@njit(cache=True, inline="always")
def _cut(path: Floats, edges: Edges, answers: RecordedAnswers) -> Floats:
    """Every corner cut off as widely as `CUTS` allow; nothing where an answer is missing."""
    last = len(path) - 1
    kept = np.empty((2 * len(path), path.shape[1]))
    write_row(kept, 0, path[0])
    count = 1
    for k in range(1, last):
        start, corner, after = path[k - 1], path[k], path[k + 1]
        if count > 1:
            start = kept[count - 1]
        is_cut = False
        for share in CUTS:
            enter, leave = corner + share * (start - corner), corner + share * (after - corner)
            answer = look_up(enter, leave, edges, answers)
            if answer == ASK:
                return path[:0].copy()
            if answer == CLEAR:
                write_row(kept, count, enter)
                write_row(kept, count + 1, leave)
                count += 2
                is_cut = True
                break
        if not is_cut:
            write_row(kept, count, corner)
            count += 1
    write_row(kept, count, path[last])
    return kept[: count + 1].copy()


# As `_cut`.
@njit(cache=True, inline="always")
def _skip(path: Floats, edges: Edges, answers: RecordedAnswers) -> Floats:
    """From each kept waypoint on to the furthest one that can be reached straight."""
    kept = np.empty_like(path)
    write_row(kept, 0, path[0])
    count, at = 1, 0
    while at < len(path) - 1:
        onward = len(path) - 1
        while onward > at + 1:
            answer = look_up(path[at], path[onward], edges, answers)
            if answer == ASK:
                return path[:0].copy()
            if answer == CLEAR:
                break
            onward -= 1
        write_row(kept, count, path[onward])
        count += 1
        at = onward
    return kept[:count].copy()


def merge_corners(path: Floats, is_clear: EdgeCheck) -> Floats:
    """The same path (m, n) [rad], corners less than `TINY` apart made one where that is clear.

    A tiny segment between long ones is a sharp corner twice: it slows the arm down to a crawl.
    """
    kept = [np.asarray(q) for q in path]
    k = 0
    while k < len(kept) - 1:
        a, b = kept[k], kept[k + 1]
        if np.abs(b - a).max() >= TINY or len(kept) == 2:
            k += 1
            continue
        is_first, is_last = k == 0, k + 1 == len(kept) - 1
        middle = a if is_first else b if is_last else (a + b) / 2
        before = is_first or is_clear(kept[k - 1], middle)
        if before and (is_last or is_clear(middle, kept[k + 2])):
            kept[k : k + 2] = [middle]
        else:
            k += 1
    return np.array(kept)


def resample(path: Floats, count: int) -> Floats:
    """The same polyline (m, n) [rad] with `count` waypoints, all its corners among them.

    Extra waypoints go where the steps are longest.  A path with more corners than `count`
    keeps them all: a corner left out would be another path.
    """
    pieces = np.ones(len(path) - 1, int)
    lengths = np.abs(np.diff(path, axis=0)).max(axis=1)
    while 1 + pieces.sum() < count:
        pieces[np.argmax(lengths / pieces)] += 1
    points = [path[0]]
    for start, end, share in zip(path[:-1], path[1:], pieces, strict=True):
        points.extend(start + (end - start) * k / share for k in range(1, share + 1))
    return np.array(points)
