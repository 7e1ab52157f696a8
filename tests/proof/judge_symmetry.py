"""Turns that leave a part as it is, as the judge reads them from `part.toml`."""

from typing import Any

import numpy as np

SAME = 1e-6
"""Entries of two rotations that differ by less are of one."""


def unit(vector) -> np.ndarray:
    vector = np.array(vector, float)
    return vector / np.linalg.norm(vector)


def about(axis, angle, through) -> np.ndarray:
    """The matrix (4, 4) of a turn about an axis (3,) through a point (3,) [m]."""
    K = np.cross(np.eye(3), axis)
    T = np.eye(4)
    T[:3, :3] = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
    T[:3, 3] = through - T[:3, :3] @ through
    return T


def turns(part: dict[str, Any], step: float) -> np.ndarray:
    """All turns (k, 4, 4) of a part, those by any angle `step` [deg] apart.

    They are what the turns about the axes make, multiplied until nothing new comes.
    """
    table = part.get("symmetry", {"fold": 1})
    axes = [(unit(a.get("axis", (0, 0, 1))), a["fold"]) for a in (table, *table.get("also", ()))]
    assert sum(fold == 0 for _, fold in axes) <= 1, "the judge turns no balls"
    point = np.array(table.get("point_mm", (0, 0, 0))) / 1000
    found = [np.eye(4)]
    for known in found:  # grows meanwhile
        for axis, fold in axes:
            new = known @ about(axis, 2 * np.pi / fold, point) if fold > 1 else known
            if not any(np.abs(new - one).max() < SAME for one in found):
                found.append(new)
    angles = np.deg2rad(np.arange(0, 360, step))
    rounds = [about(axis, a, point) for axis, fold in axes if fold == 0 for a in angles]
    return np.array([R @ S for R in rounds or [np.eye(4)] for S in found])


def made(part: dict[str, Any], turn: str) -> list[np.ndarray]:
    """What a grasp's name may mean by a turn: by so many degrees about the main axis.

    After it stands which of the other turns comes first: the judge tries each.
    """
    table = part["symmetry"]
    axes = [(unit(a.get("axis", (0, 0, 1))), a["fold"]) for a in (table, *table.get("also", ()))]
    main, fold = max(axes, key=lambda one: one[1] or np.inf)
    angle, point = float(turn.split("+")[0]), np.array(table.get("point_mm", (0, 0, 0))) / 1000
    if fold > 0:
        # Names have whole degrees.
        angle = 360 / fold * round(angle * fold / 360)
    first = about(main, np.deg2rad(angle), point)
    others = turns(part | {"symmetry": table | {"fold": 1}}, 360) if fold == 0 else turns(part, 360)
    return [first @ S for S in others] if "+" in turn else [first]
