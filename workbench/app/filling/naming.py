"""What a family of grasps is called: by how the hand comes to the part."""

from collections.abc import Collection

import numpy as np

from workbench.model.geometry import Floats
from workbench.model.part import Entry, Part
from workbench.model.part_edits import grasp_of

LENGTHWISE = 0.8
"""Cosine from which a direction is that of the part's length."""

PARTLY = 0.6
"""Share of the part's extent below which fingers close on a part of it."""


def make_name(part: Part, entry: Entry, taken: Collection[str]) -> str:
    """A name that is new among those taken, such as `across` or `end-2`."""
    kind = _kind(part, entry)
    number = 1
    while (name := f"{kind}-{number}" if number > 1 else kind) in taken:
        number += 1
    return name


def _kind(part: Part, entry: Entry) -> str:
    grasp = grasp_of(entry)
    points = np.asarray(part.mesh.points)
    length = _length(part, points)
    R = grasp.T_part_tcp.rotation
    if grasp.opening == 0.0 and grasp.grip == 0.0:
        return "end" if abs(float(R[:, 2] @ length)) > LENGTHWISE else "face"
    if grasp.grip < PARTLY * float(np.ptp(points @ R[:, 1])):
        return "edge"
    if abs(float(R[:, 2] @ length)) > LENGTHWISE:
        return "end"
    return "along" if abs(float(R[:, 1] @ length)) > LENGTHWISE else "across"


def _length(part: Part, points: Floats) -> Floats:
    """The direction (3,) of the part's symmetry, or else in which it is longest."""
    if not part.symmetry.is_none:
        return np.array(part.symmetry.axes[0].axis)
    return np.eye(3)[int(np.argmax(np.ptp(points, axis=0)))]
